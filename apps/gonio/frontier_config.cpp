// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "apps/gonio/locate.h"
#include "core/config.h"
#include "core/error.h"

namespace gonio {
namespace {

constexpr Reconstruction kReconstructions[] = {Reconstruction::kDsbrdf, Reconstruction::kProcess,
                                               Reconstruction::kPca, Reconstruction::kScattered};

std::vector<std::string> TextsOr(const ConfigNode& node, const char* key,
                                 std::vector<std::string> fallback) {
  return node.Has(key) ? node.Texts(key) : std::move(fallback);
}

// Whole numbers, ascending.
std::vector<int> ReadAscending(const ConfigNode& node, const char* key, int min, int max) {
  std::vector<int> numbers;
  for (const double number : node.Numbers(key, 0, Range::Between(min, max))) {
    if (number != std::floor(number)) node.Fail(key, "must hold whole numbers");
    if (!numbers.empty() && number <= numbers.back()) {
      node.Fail(key, fmt::format("must ascend: {} comes after {}", number, numbers.back()));
    }
    numbers.push_back(static_cast<int>(number));
  }
  return numbers;
}

// The file of that name beside the study, or one that gonio comes with.
std::filesystem::path Beside(const ConfigNode& node, const std::string& name) {
  const auto own = std::filesystem::path(node.file()).parent_path() / name;
  return std::filesystem::exists(own) ? own : LocateConfig(name);
}

// A plan file's name, or its content: that has more than one line.
Plan ReadPlan(const ConfigNode& node, const std::string& contestant) {
  const std::string plan = node.Text("plan");
  if (plan.find('\n') == std::string::npos) return LoadPlan(Beside(node, plan));
  return ParsePlan(plan, fmt::format("{}: plan of {}", node.file(), contestant));
}

std::string ReadName(const ConfigNode& node) {
  const std::string name = node.Text("name");
  const auto fine = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '+' || c == '_' || c == '.';
  };
  if (!std::all_of(name.begin(), name.end(), fine) || name.front() == '.') {
    node.Fail("name", fmt::format("is \"{}\", must be of letters, digits, - + _ .", name));
  }
  return name;
}

Contestant ReadContestant(const ConfigNode& node) {
  Contestant contestant;
  contestant.name = ReadName(node);
  contestant.plan = ReadPlan(node, contestant.name);
  std::vector<std::string> names;
  for (const Reconstruction r : kReconstructions) names.emplace_back(NameOf(r));
  const std::string reconstruction = node.Choice("reconstruction", names);
  contestant.reconstruction =
      kReconstructions[std::find(names.begin(), names.end(), reconstruction) - names.begin()];
  if (node.Has("prior")) {
    contestant.learned_prior = node.Choice("prior", {"learned", "plan"}) == "learned";
  }
  contestant.per_budget = node.BoolOr("per_budget", false);
  return contestant;
}

std::vector<Contestant> ReadContestants(const ConfigNode& root) {
  std::vector<Contestant> contestants;
  std::set<std::string> names;
  for (const ConfigNode& node : root.MapList("contestants")) {
    contestants.push_back(ReadContestant(node));
    if (!names.insert(contestants.back().name).second) {
      node.Fail("name", fmt::format("there are two called \"{}\"", contestants.back().name));
    }
    node.RefuseUnknownKeys();
  }
  if (contestants.empty()) root.Fail("contestants", "is empty");
  return contestants;
}

std::vector<std::string> ReadNoises(const ConfigNode& root) {
  const std::vector<std::string> noises = TextsOr(root, "noise", {"none", "default"});
  if (noises.empty()) root.Fail("noise", "is empty");
  std::set<std::string> seen;
  for (const std::string& noise : noises) {
    if (noise != "none" && noise != "default") {
      root.Fail("noise", fmt::format("holds \"{}\", must be of none, default", noise));
    }
    if (!seen.insert(noise).second) root.Fail("noise", fmt::format("holds \"{}\" twice", noise));
  }
  return noises;
}

RigFile ReadRigFile(const ConfigNode& root) {
  const std::string name = root.TextOr("rig", "sim-rig.yaml");
  return LoadRig(Beside(root, name));
}

}  // namespace

const char* NameOf(Reconstruction reconstruction) {
  switch (reconstruction) {
    case Reconstruction::kDsbrdf:
      return "dsbrdf";
    case Reconstruction::kProcess:
      return "process";
    case Reconstruction::kPca:
      return "pca";
    case Reconstruction::kScattered:
      return "scattered";
  }
  return "";
}

bool Contestant::NeedsPca() const {
  return reconstruction == Reconstruction::kPca || plan.kind == PlannerKind::kPivotedQr ||
         plan.kind == PlannerKind::kFrost;
}

FrontierConfig LoadFrontier(const std::filesystem::path& path) {
  const ConfigNode root = ConfigNode::Load(path);
  root.Integer("version", 1, 1);
  root.Choice("kind", {"frontier"});
  FrontierConfig study;
  study.name = root.Text("name");
  study.materials = root.Texts("materials");
  if (study.materials.empty()) root.Fail("materials", "is empty");
  study.held_out = TextsOr(root, "held_out", {});
  study.extra_training = TextsOr(root, "extra_training", {});
  study.folds = root.Integer("folds", 2);
  study.rig = ReadRigFile(root);
  study.contestants = ReadContestants(root);
  study.budgets = root.Has("budgets") ? ReadAscending(root, "budgets", 1, 1000000)
                                      : std::vector<int>{5, 10, 20, 32, 64, 128, 256};
  const std::vector<int> seeds =
      root.Has("seeds") ? ReadAscending(root, "seeds", 0, 1000000000) : std::vector<int>{1};
  study.seeds.assign(seeds.begin(), seeds.end());
  study.noises = ReadNoises(root);
  if (root.Has("targets")) study.targets = root.Numbers("targets", 0, Range::Positive());
  if (root.Has("dense_method")) {
    study.dense = FitMethodFromName(root.Choice("dense_method", {"em", "joint", "continuous"}));
  }
  study.theta_d_stride = root.IntegerOr("theta_d_stride", study.theta_d_stride, 1, 90);
  study.phi_stride = root.IntegerOr("phi_stride", study.phi_stride, 1, 180);
  root.RefuseUnknownKeys();
  return study;
}

}  // namespace gonio
