// SPDX-License-Identifier: Apache-2.0
#include "acquisition/time_estimate.h"

#include <gtest/gtest.h>

#include "acquisition/kinematics.h"
#include "tests/scenario/bench.h"

namespace gonio {
namespace {

TEST(EstimateScan, AddsUpMovesSettlingAndFrames) {
  const Bench bench;
  std::vector<DirectionPair> poses;
  for (const HalfDiff& angles : FourPoses()) poses.push_back(ToDirections(angles));
  const TimeEstimate estimate = EstimateScan(bench.rig, poses, Seconds(0.2));
  EXPECT_EQ(estimate.poses, 4);
  EXPECT_DOUBLE_EQ(estimate.settling.count(), 4 * bench.rig.motion.settle.count());
  EXPECT_DOUBLE_EQ(estimate.exposing.count(), 4 * 0.2);
  EXPECT_GT(estimate.travel, Seconds::zero());
  EXPECT_EQ(estimate.total(), estimate.travel + estimate.settling + estimate.exposing);
}

TEST(EstimateScan, LeavesOutWhatCannotBeReached) {
  const Bench bench;
  const std::vector<DirectionPair> poses = {ToDirections(Degrees(5, 20)),
                                            ToDirections(OutOfReach())};
  EXPECT_EQ(EstimateScan(bench.rig, poses, Seconds(1)).poses, 1);
  EXPECT_EQ(EstimateScan(bench.rig, {}, Seconds(1)).total(), Seconds::zero());
}

// Example failure is an estimate that forgets what every pose of a session costs: it must come near
// the time that the simulated rig really takes.
TEST(EstimateScan, AgreesWithASessionOfTheSamePoses) {
  Bench bench;
  ScriptedPlanner planner(FourPoses());
  const SessionSummary session = bench.Run(planner);
  std::vector<DirectionPair> poses;
  for (const HalfDiff& angles : FourPoses()) poses.push_back(ToDirections(angles));
  const TimeEstimate estimate = EstimateScan(bench.rig, poses, session.exposing / 4);
  const Seconds first_move =  // the session's way from where homing ended
      session.duration - session.preparation - estimate.total();
  EXPECT_GE(first_move, Seconds(-0.5));
  EXPECT_LT(first_move, Seconds(20));
}

// Dense reference of the field: 8,100 poses on such a stage take about four hours.
TEST(EstimateDenseScan, TakesHoursAndItsThinnedVersionAboutItsShare) {
  const Bench bench;
  const TimeEstimate dense = EstimateDenseScan(bench.rig, NominalExposing(bench.rig));
  EXPECT_GT(dense.poses, 7000);
  EXPECT_LE(dense.poses, 8100);
  EXPECT_GT(dense.total(), Seconds(2 * 3600));
  EXPECT_LT(dense.total(), Seconds(8 * 3600));
  const TimeEstimate thinned = EstimateDenseScan(bench.rig, NominalExposing(bench.rig), 0.3);
  EXPECT_NEAR(static_cast<double>(thinned.poses) / dense.poses, 0.3, 0.02);
  EXPECT_NEAR(thinned.total() / dense.total(), 0.3, 0.05);
}

TEST(NominalExposing, CountsBracketsThatTheCameraCanDo) {
  RigConfig rig;
  rig.dense_brackets = 3;
  rig.camera.min_exposure = Seconds(0.001);
  rig.camera.max_exposure = Seconds(10);
  rig.camera.readout = Seconds(0.5);
  EXPECT_DOUBLE_EQ(NominalExposing(rig).count(), 3 * 0.8);
  rig.camera.max_exposure = Seconds(0.1);
  EXPECT_DOUBLE_EQ(NominalExposing(rig).count(), 3 * 0.6);
}

}  // namespace
}  // namespace gonio
