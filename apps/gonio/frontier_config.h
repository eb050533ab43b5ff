// SPDX-License-Identifier: Apache-2.0
// A frontier study: how good are planners and reconstructions after n poses, and what do the poses
// cost?

#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/gonio/build_rig.h"
#include "brdf/metrics.h"
#include "fitting/table_fit.h"
#include "planner/plan.h"

namespace gonio {

// What makes a reflectance of the samples of a session.
enum class Reconstruction { kDsbrdf, kProcess, kPca, kScattered };

// "dsbrdf", "process", "pca", "scattered"
const char* NameOf(Reconstruction reconstruction);

// A planner and what is made of its samples.
struct Contestant {
  std::string name;  // letters, digits, '-', '+', '_', '.': it names files
  Plan plan;
  Reconstruction reconstruction = Reconstruction::kDsbrdf;
  // Plan and reconstruction use the prior learned from the other folds; else the plan's own.
  bool learned_prior = true;
  // A session of its own for every budget, as grids need; else the first n poses of the longest.
  bool per_budget = false;

  // Its directions or its reconstruction come from the training materials' principal components.
  bool NeedsPca() const;
  // It knows something of the other folds' materials.
  bool IsTaught() const { return learned_prior || NeedsPca(); }
};

struct FrontierConfig {
  std::string name;
  std::vector<std::string> materials;       // file names or patterns, scored by cross-validation
  std::vector<std::string> held_out;        // scored with what all `materials` taught
  std::vector<std::string> extra_training;  // learned from, never scored
  int folds = 5;                            // 2 .. number of materials
  RigFile rig;
  std::vector<Contestant> contestants;
  std::vector<int> budgets;  // poses, ascending
  std::vector<std::uint64_t> seeds;
  std::vector<std::string> noises;  // "none", "default"
  std::vector<double> targets;      // predicted errors at which a session might have been stopped
  FitMethod dense = FitMethod::kJoint;
  int theta_d_stride = 4, phi_stride = 12;  // of the metrics

  MetricOptions Metrics() const {
    return {.phi_stride = phi_stride, .theta_d_stride = theta_d_stride};
  }
};

// docs/frontier.md describes the file. Plans and the rig are looked for beside it, then among those
// that gonio comes with. Throws ConfigError naming file, line and key.
FrontierConfig LoadFrontier(const std::filesystem::path& path);

}  // namespace gonio
