// SPDX-License-Identifier: Apache-2.0
#include "fitting/learn_prior.h"

#include <fmt/format.h>

#include <cmath>
#include <set>
#include <vector>

#include "core/error.h"
#include "core/task_pool.h"
#include "fitting/lobe_learning.h"

namespace gonio {
namespace {

void RequireDistinct(std::span<const TrainingMaterial> materials) {
  if (static_cast<int>(materials.size()) < kLeastMaterials) {
    throw ConfigError(fmt::format("a prior is learned from {} materials or more, not from {}",
                                  kLeastMaterials, materials.size()));
  }
  std::set<std::string> names;
  for (const TrainingMaterial& material : materials) {
    if (!names.insert(material.name).second) {
      throw ConfigError(fmt::format("{}: is named twice among the materials", material.name));
    }
  }
}

// Each material in the basis, in order.
std::vector<MaterialField> SampleAll(const FieldSampler& sampler,
                                     std::span<const TrainingMaterial> materials, int threads) {
  std::vector<MaterialField> fields(materials.size());
  ForEachTask(materials.size(), threads, {},
              [&](std::size_t i) { fields[i] = sampler.Sample(materials[i]); });
  return fields;
}

}  // namespace

void LearnOptions::Check() const {
  const auto require = [](bool holds, const char* option, const char* condition) {
    if (!holds) throw ConfigError(fmt::format("prior.{}: must be {}", option, condition));
  };
  require(basis.theta_h_knots() >= kMinKnots, "theta_h_knots", "4 or more");
  require(basis.theta_d_knots() >= kMinKnots, "theta_d_knots", "4 or more");
  require(floor > 0 && std::isfinite(floor), "floor", "> 0");
  require(luminance_components > 0, "luminance_components", "> 0");
  require(chroma_components > 0, "chroma_components", "> 0");
  require(threads >= 1, "threads", "1 or more");
  require(raster.theta_h > 0 && raster.theta_d > 0 && raster.phi_d > 0, "raster", "> 0");
  CheckShape(shape);
}

Prior LearnPrior(std::span<const TrainingMaterial> materials, const LearnOptions& options) {
  options.Check();
  RequireDistinct(materials);
  const FieldSampler sampler(options.basis, options.floor, options.raster);
  const std::vector<MaterialField> fields = SampleAll(sampler, materials, options.threads);
  std::vector<const MaterialField*> all;
  for (const MaterialField& field : fields) all.push_back(&field);
  Prior prior = GenericPrior(options.shape);
  prior.name = options.name;
  for (const TrainingMaterial& material : materials) prior.materials.push_back(material.name);
  if (options.lobes) LearnLobes(materials, {.threads = options.threads}, &prior);
  prior.process = std::make_shared<ProcessPrior>(
      LearnProcess(all, options.basis, options.floor, sampler.metric(),
                   {options.luminance_components, options.chroma_components}));
  return prior;
}

}  // namespace gonio
