// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_learning.h"

#include <memory>
#include <mutex>
#include <vector>

#include "apps/gonio/open_any.h"
#include "planner/prior_calibration.h"

namespace gonio {

namespace {

// Materials in memory, under their names.
class OpenedMaterials {
 public:
  explicit OpenedMaterials(std::span<const FrontierMaterial> materials) {
    for (const FrontierMaterial& material : materials) {
      brdfs_.push_back(OpenAny(material.path));
      training_.push_back({material.name, brdfs_.back().get()});
    }
  }
  const std::vector<TrainingMaterial>& training() const { return training_; }

 private:
  std::vector<std::unique_ptr<Brdf>> brdfs_;
  std::vector<TrainingMaterial> training_;
};

}  // namespace

Prior LearnFrom(std::span<const FrontierMaterial> materials, const std::string& name) {
  LearnOptions options;
  options.name = name;
  return LearnCalibratedPrior(OpenedMaterials(materials).training(), options);
}

std::shared_ptr<const PcaBasis> LearnPca(std::span<const FrontierMaterial> materials) {
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  return std::make_shared<const PcaBasis>(OpenedMaterials(materials).training());
}

}  // namespace gonio
