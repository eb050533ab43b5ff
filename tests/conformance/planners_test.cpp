// SPDX-License-Identifier: Apache-2.0
// Every planner keeps the promises of planner/planner.h.
#include "core/units.h"
#include "planner/plan.h"
#include "tests/conformance/planner.h"
#include "tests/fitting/training_set.h"

namespace gonio {
namespace {

// What a rig with a shadowing camera and short arms leaves.
bool WithinReach(const DirectionPair& pair) {
  return AngleBetween(pair.wi, pair.wo) > RadFromDeg(25) && pair.cos_theta_i() > 0.3 &&
         pair.cos_theta_o() > 0.3;
}

// Small rasters and a small model: the promises do not depend on size.
constexpr const char* kRest = R"(
version: 1
name: conformance
candidates: {theta_h_count: 12, theta_d_count: 12}
fit: {lobes: 2, knots: 4}
)";

// Learned once; planners only read it.
std::shared_ptr<const PcaBasis> Basis() {
  static const auto basis =
      std::make_shared<const PcaBasis>(TrainingSet().materials(), AngleGrid(16, 10, 4));
  return basis;
}

PlannerSubject Subject(const std::string& plan_text, const Reachable& reachable) {
  const Plan plan = ParsePlan(kRest + plan_text, "plan.yaml");
  PlannerInputs inputs;
  inputs.reachable = reachable;
  inputs.pca = Basis();
  inputs.seed = 7;
  return {.planner = MakePlanner(plan, inputs),
          .candidates = MakeCandidates(plan.candidates, reachable)};
}

PlannerFactory Of(const std::string& plan_text, const Reachable& reachable = {}) {
  return [plan_text, reachable] { return Subject(plan_text, reachable); };
}

constexpr const char* kGrid = "planner: grid\n";
constexpr const char* kThinned = "planner: grid\ngrid: {every_theta_h: 3, every_theta_d: 2}\n";
constexpr const char* kCoarse = "planner: grid\nmax_poses: 20\n";
constexpr const char* kRandom = "planner: random\nmax_poses: 30\n";
constexpr const char* kRandomAll = "planner: random\n";
constexpr const char* kInformation = "planner: information\nmax_poses: 30\n";
constexpr const char* kInformationToTheEnd =
    "planner: information\nmax_poses: 1000\ninformation: {min_gain: 0.01}\n";
constexpr const char* kInformationToATarget =
    "planner: information\nmax_poses: 60\ninformation: {target_error: 0.02}\n";
constexpr const char* kNielsen = "planner: nielsen\n";
constexpr const char* kPivotedQr = "planner: pivoted-qr\nmax_poses: 40\n";
constexpr const char* kFrost = "planner: frost\nmax_poses: 40\n";
constexpr const char* kSlices = "planner: slices\nmax_poses: 30\n";
constexpr const char* kSlicesToTheEnd = "planner: slices\n";
constexpr const char* kHierarchical = "planner: hierarchical\nmax_poses: 30\n";
constexpr const char* kHierarchicalToTheEnd = "planner: hierarchical\n";

INSTANTIATE_TEST_SUITE_P(Grid, PlannerConformance, testing::Values(Of(kGrid)));
INSTANTIATE_TEST_SUITE_P(Thinned, PlannerConformance, testing::Values(Of(kThinned)));
INSTANTIATE_TEST_SUITE_P(Coarse, PlannerConformance, testing::Values(Of(kCoarse)));
INSTANTIATE_TEST_SUITE_P(Random, PlannerConformance, testing::Values(Of(kRandom), Of(kRandomAll)));
INSTANTIATE_TEST_SUITE_P(Information, PlannerConformance,
                         testing::Values(Of(kInformation), Of(kInformationToTheEnd),
                                         Of(kInformationToATarget)));
INSTANTIATE_TEST_SUITE_P(Lists, PlannerConformance,
                         testing::Values(Of(kNielsen), Of(kPivotedQr), Of(kFrost)));
INSTANTIATE_TEST_SUITE_P(Slices, PlannerConformance,
                         testing::Values(Of(kSlices), Of(kSlicesToTheEnd)));
INSTANTIATE_TEST_SUITE_P(Hierarchical, PlannerConformance,
                         testing::Values(Of(kHierarchical), Of(kHierarchicalToTheEnd)));
INSTANTIATE_TEST_SUITE_P(WithinReach, PlannerConformance,
                         testing::Values(Of(kGrid, WithinReach), Of(kThinned, WithinReach),
                                         Of(kCoarse, WithinReach), Of(kRandom, WithinReach),
                                         Of(kInformation, WithinReach), Of(kNielsen, WithinReach),
                                         Of(kPivotedQr, WithinReach), Of(kFrost, WithinReach),
                                         Of(kSlices, WithinReach), Of(kHierarchical, WithinReach)));

}  // namespace
}  // namespace gonio
