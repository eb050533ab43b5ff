// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_learning.h"

#include <memory>
#include <vector>

#include "apps/gonio/open_any.h"
#include "fitting/learn_prior.h"

namespace gonio {

Prior LearnFrom(std::span<const FrontierMaterial> materials, const std::string& name) {
  std::vector<std::unique_ptr<Brdf>> brdfs;
  std::vector<TrainingMaterial> training;
  for (const FrontierMaterial& material : materials) {
    brdfs.push_back(OpenAny(material.path));
    training.push_back({material.name, brdfs.back().get()});
  }
  LearnOptions options;
  options.name = name;
  return LearnPrior(training, options);
}

}  // namespace gonio
