// SPDX-License-Identifier: Apache-2.0
#include "acquisition/geometry_calibration/find_target.h"

#include <gtest/gtest.h>

#include "tests/geometry/planted.h"

namespace gonio {
namespace {

const ArmAngles kFromAbove = {RadFromDeg(90), RadFromDeg(60), RadFromDeg(30), RadFromDeg(75)};

// The rig as it believes to be, with sharp edges to a fraction of a pixel.
SimConfig Exact() {
  SimConfig truth = PlantedTruth();
  const RigConfig rig = BelievedRig();
  truth.focal_length = rig.imaging.focal_length;
  truth.camera_distance = rig.imaging.camera_distance;
  truth.light_distance = rig.imaging.light_distance;
  truth.principal_point = {};
  truth.camera_turn = {};
  truth.axis_offset = {};
  truth.target = {};
  return truth;
}

// Example failure is half a pixel between the simulated lens and the finder.
TEST(FindCorners, FindsThemWhereTheLensPutsThem) {
  const auto near = PredictCorners(Belief(BelievedRig()), kBoard, kFromAbove);
  const Frame frame = PlantedRig(Exact(), 1).See(SimTarget::Kind::kCheckerboard, kFromAbove);
  const auto corners = FindCorners(frame, 4095, kBoard, near);
  ASSERT_TRUE(corners);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < near.size(); ++i) {
    EXPECT_LT(((*corners)[i] - near[i]).norm(), 0.2) << i;
    mean += ((*corners)[i] - near[i]) / static_cast<double>(near.size());
  }
  EXPECT_LT(mean.norm(), 0.02);
}

TEST(FindCorners, SeesNoBoardInAMirror) {
  const auto near = PredictCorners(Belief(BelievedRig()), kBoard, kFromAbove);
  const Frame frame = PlantedRig(Exact(), 1).See(SimTarget::Kind::kMirror, kFromAbove);
  EXPECT_FALSE(FindCorners(frame, 4095, kBoard, near));
}

TEST(FindHighlight, FindsTheLightInTheMirror) {
  const ArmAngles arms = {0, RadFromDeg(60), RadFromDeg(184), RadFromDeg(62)};
  const Frame frame = PlantedRig(Exact(), 2).See(SimTarget::Kind::kMirror, arms);
  const auto at = FindHighlight(frame, 4095);
  ASSERT_TRUE(at) << at.error().message;
  EXPECT_LT((*at - PredictHighlight(Belief(BelievedRig()), arms)).norm(), 0.05);
}

TEST(FindHighlight, SaysWhyThereIsNone) {
  const Frame board = PlantedRig(Exact(), 1).See(SimTarget::Kind::kCheckerboard, kFromAbove);
  const auto none = FindHighlight(board, 4095);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kRefused);
  Frame dark = board;
  std::fill(dark.counts.begin(), dark.counts.end(), std::uint16_t{64});
  EXPECT_EQ(FindHighlight(dark, 4095).error().message, "no highlight: nothing is bright");
}

}  // namespace
}  // namespace gonio
