// SPDX-License-Identifier: Apache-2.0
// Every way in which a plan file can be wrong, and the one line each of them gets.
#include <gtest/gtest.h>

#include "core/error.h"
#include "planner/plan.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

std::string Complaint(const std::string& text) {
  return MessageOf<ConfigError>([&] { ParsePlan(text, "plan.yaml"); });
}

// Four lines that are right, and what follows.
std::string Information(const std::string& more) {
  return Complaint("version: 1\nname: x\nplanner: information\nmax_poses: 10\n" + more);
}
std::string Grid(const std::string& more) {
  return Complaint("version: 1\nname: x\nplanner: grid\n" + more);
}

TEST(BadPlan, LacksARequiredKey) {
  EXPECT_EQ(Complaint("name: x\nplanner: grid\n"), "plan.yaml:1: version: is missing");
  EXPECT_EQ(Complaint("version: 1\nplanner: grid\n"), "plan.yaml:1: name: is missing");
  EXPECT_EQ(Complaint("version: 1\nname: x\n"), "plan.yaml:1: planner: is missing");
  EXPECT_EQ(Complaint("version: 1\nname: x\nplanner: information\n"),
            "plan.yaml:1: max_poses: is missing");
}

TEST(BadPlan, IsOfAnotherVersion) {
  EXPECT_EQ(Complaint("version: 2\nname: x\nplanner: grid\n"),
            "plan.yaml:1: version: is 2, must be between 1 and 1");
}

TEST(BadPlan, NamesAnUnknownPlanner) {
  EXPECT_EQ(Complaint("version: 1\nname: x\nplanner: clever\n"),
            "plan.yaml:3: planner: is \"clever\", must be one of frost, grid, "
            "hierarchical, information, nielsen, pivoted-qr, random, slices");
}

TEST(BadPlan, HasABudgetOutOfRange) {
  EXPECT_EQ(Complaint("version: 1\nname: x\nplanner: information\nmax_poses: 0\n"),
            "plan.yaml:4: max_poses: is 0, must be between 1 and 1000000");
  EXPECT_EQ(Complaint("version: 1\nname: x\nplanner: information\nmax_poses: ten\n"),
            "plan.yaml:4: max_poses: is \"ten\", must be a finite number");
  EXPECT_EQ(Complaint("version: 1\nname: x\nplanner: information\nmax_poses: 2.5\n"),
            "plan.yaml:4: max_poses: is 2.5, must be a whole number");
  EXPECT_EQ(Grid("max_poses: -1\n"),
            "plan.yaml:4: max_poses: is -1, must be between 0 and 1000000");
}

TEST(BadPlan, HasABadCandidateKey) {
  EXPECT_EQ(Grid("candidates: 3\n"), "plan.yaml:4: candidates: must hold keys and values");
  EXPECT_EQ(Grid("candidates:\n  theta_h_count: 0\n"),
            "plan.yaml:5: candidates.theta_h_count: is 0, must be between 1 and 1000");
  EXPECT_EQ(Grid("candidates:\n  theta_d_count: 1001\n"),
            "plan.yaml:5: candidates.theta_d_count: is 1001, must be between 1 and 1000");
  EXPECT_EQ(Grid("candidates:\n  spacing: log\n"),
            "plan.yaml:5: candidates.spacing: is \"log\", must be one of merl, uniform");
  EXPECT_EQ(Grid("candidates:\n  phi_d: 90\n"),
            "plan.yaml:5: candidates.phi_d: is \"90\", must be one of across, spread");
  EXPECT_EQ(Grid("candidates:\n  phi_span_deg: 181\n"),
            "plan.yaml:5: candidates.phi_span_deg: is 181, must be between 0 and 180");
  EXPECT_EQ(Grid("candidates:\n  max_polar_deg: 95\n"),
            "plan.yaml:5: candidates.max_polar_deg: is 95, must be between 10 and 89.9");
  EXPECT_EQ(Grid("candidates:\n  max_polar: 80\n"),
            "plan.yaml:5: candidates.max_polar: is not a known key");
}

TEST(BadPlan, HasABadGridKey) {
  EXPECT_EQ(Grid("grid:\n  every_theta_h: 0\n"),
            "plan.yaml:5: grid.every_theta_h: is 0, must be between 1 and 1000");
  EXPECT_EQ(Grid("grid:\n  every_theta_d: 1.5\n"),
            "plan.yaml:5: grid.every_theta_d: is 1.5, must be a whole number");
  EXPECT_EQ(Grid("grid:\n  every: 3\n"), "plan.yaml:5: grid.every: is not a known key");
}

TEST(BadPlan, HasABadInformationKey) {
  EXPECT_EQ(Information("information:\n  objective: mse\n"),
            "plan.yaml:6: information.objective: is \"mse\", must be one of male, relative");
  EXPECT_EQ(Information("information:\n  target_error: -0.1\n"),
            "plan.yaml:6: information.target_error: is -0.1, must be >= 0");
  EXPECT_EQ(Information("information:\n  min_gain: 2\n"),
            "plan.yaml:6: information.min_gain: is 2, must be between 0 and 1");
  EXPECT_EQ(Information("information:\n  max_polar_deg: 5\n"),
            "plan.yaml:6: information.max_polar_deg: is 5, must be between 10 and 90");
  EXPECT_EQ(Information("information:\n  relative_noise: 0\n"),
            "plan.yaml:6: information.relative_noise: is 0, must be > 0");
  EXPECT_EQ(Information("information:\n  repeat_length: .nan\n"),
            "plan.yaml:6: information.repeat_length: is \".nan\", must be a finite number");
  EXPECT_EQ(Information("information:\n  seed: 3\n"),
            "plan.yaml:6: information.seed: is not a known key");
}

TEST(BadPlan, HasABadFitKey) {
  EXPECT_EQ(Information("fit:\n  lobes: 6\n"),
            "plan.yaml:6: fit.lobes: is 6, must be between 1 and 5");
  EXPECT_EQ(Information("fit:\n  knots: 3\n"),
            "plan.yaml:6: fit.knots: is 3, must be between 4 and 20");
  EXPECT_EQ(Information("fit:\n  floor_per_sr: 0\n"),
            "plan.yaml:6: fit.floor_per_sr: is 0, must be > 0");
  EXPECT_EQ(Information("fit:\n  huber: -1\n"), "plan.yaml:6: fit.huber: is -1, must be > 0");
  EXPECT_EQ(Information("fit:\n  model_error: 0\n"),
            "plan.yaml:6: fit.model_error: is 0, must be > 0");
  EXPECT_EQ(Information("fit:\n  model_error_weight: -1\n"),
            "plan.yaml:6: fit.model_error_weight: is -1, must be >= 0");
  EXPECT_EQ(Information("fit:\n  max_iterations: 0\n"),
            "plan.yaml:6: fit.max_iterations: is 0, must be between 1 and 10000");
  EXPECT_EQ(Information("fit:\n  prior: [a]\n"), "plan.yaml:6: fit.prior: must be a single value");
  EXPECT_EQ(Information("fit:\n  starts: 3\n"), "plan.yaml:6: fit.starts: is not a known key");
}

TEST(BadPlan, NamesAPriorFileThatIsMissing) {
  EXPECT_EQ(Information("fit:\n  prior: gone.yaml\n"),
            "gone.yaml: cannot read: No such file or directory");
}

TEST(BadPlan, GivesAPriorFileAShape) {
  EXPECT_EQ(Information("fit:\n  prior: learned.yaml\n  lobes: 3\n"),
            "plan.yaml:6: fit.prior: a prior file brings its own lobes and knots; leave those keys "
            "out");
}

TEST(BadPlan, HoldsSectionsOfAnotherPlanner) {
  EXPECT_EQ(Grid("information:\n  min_gain: 0.1\n"),
            "plan.yaml:4: information: is not a known key");
  EXPECT_EQ(Information("grid:\n  every_theta_h: 3\n"), "plan.yaml:5: grid: is not a known key");
}

TEST(BadPlan, HoldsAnUnknownOrRepeatedKey) {
  EXPECT_EQ(Grid("seed: 3\n"), "plan.yaml:4: seed: is not a known key");
  EXPECT_EQ(Grid("name: y\n"), "plan.yaml:4: name: stands twice");
}

TEST(BadPlan, IsNoYamlMapping) {
  EXPECT_EQ(Complaint(""), "plan.yaml:1: must hold keys and values (\"key: value\")");
  EXPECT_EQ(Complaint("- 1\n"), "plan.yaml:1: must hold keys and values (\"key: value\")");
}

TEST(BadPlan, IsMissing) {
  const TempDir dir;
  const auto path = dir / "gone.yaml";
  EXPECT_EQ(MessageOf<ConfigError>([&] { LoadPlan(path); }),
            path.string() + ": cannot read: No such file or directory");
}

}  // namespace
}  // namespace gonio
