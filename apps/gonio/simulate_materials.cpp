// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/simulate_materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "apps/gonio/locate.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/summary.h"
#include "core/error.h"
#include "fitting/process_material.h"
#include "sim/random.h"

namespace gonio {
namespace {

constexpr std::uint64_t kFirstStream = 1000;  // beyond those of the rig's devices

NamedMaterial Draw(const std::shared_ptr<const ProcessModel>& model, std::uint64_t seed, int i) {
  Random random(seed, kFirstStream + static_cast<std::uint64_t>(i));
  std::array<Eigen::VectorXd, kChannels> weights;
  for (const ProcessModel::Group& group : model->groups()) {
    for (int s = group.first_series; s < group.first_series + group.series; ++s) {
      weights[s].resize(group.size);
      for (double& weight : weights[s]) weight = random.Normal();
    }
  }
  const std::string name = fmt::format("draw {}", i + 1);
  return {name, std::make_shared<ProcessMaterial>(model, weights, name), true};
}

}  // namespace

std::vector<NamedMaterial> OpenMaterials(const std::vector<std::string>& files,
                                         const std::vector<NamedPlan>& plans) {
  std::vector<NamedMaterial> materials;
  std::set<std::pair<std::string, std::string>> warned;  // prior and material
  for (const std::string& file : files) {
    const std::filesystem::path path = LocateConfig(file);
    std::shared_ptr<const Brdf> brdf = OpenAny(path);
    materials.push_back({brdf->name(), brdf});
    for (const NamedPlan& plan : plans) {
      const Prior& prior = plan.plan.prior;
      if (warned.emplace(prior.name, path.stem()).second) WarnIfSeen(prior, path.stem());
    }
  }
  return materials;
}

const Prior& SourceOfDraws(const std::vector<NamedPlan>& plans) {
  const auto learned = std::find_if(plans.begin(), plans.end(), [](const NamedPlan& plan) {
    return plan.plan.prior.process != nullptr;
  });
  if (learned == plans.end()) {
    throw ConfigError(
        "name a material to simulate, or a learned prior (--prior FILE) to draw materials from");
  }
  return learned->plan.prior;
}

std::vector<NamedMaterial> DrawMaterials(int count, std::uint64_t seed,
                                         const std::vector<NamedPlan>& plans) {
  const auto model = std::make_shared<const ProcessModel>(*SourceOfDraws(plans).process);
  std::vector<NamedMaterial> materials;
  for (int i = 0; i < count; ++i) materials.push_back(Draw(model, seed, i));
  return materials;
}

}  // namespace gonio
