// SPDX-License-Identifier: Apache-2.0
#include "acquisition/geometry_calibration/bundle.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sim/random.h"
#include "tests/geometry/planted.h"

namespace gonio {
namespace {

struct Views {
  std::vector<BoardView> boards;
  std::vector<MirrorView> mirrors;
};

// Through images of the simulated lens and the finders.
Views Photographed(const SimConfig& truth, std::uint64_t seed) {
  const RigConfig rig = BelievedRig();
  PlantedRig planted(truth, seed);
  Views views;
  for (const ArmAngles& arms : BoardPoses(rig)) {
    const Frame frame = planted.See(SimTarget::Kind::kCheckerboard, arms);
    const auto near = PredictCorners(Belief(rig), kBoard, arms);
    if (auto corners = FindCorners(frame, 4095, kBoard, near)) {
      views.boards.push_back({arms, *corners});
    }
  }
  for (const ArmAngles& arms : MirrorPoses(rig)) {
    const auto highlight = FindHighlight(planted.See(SimTarget::Kind::kMirror, arms), 4095);
    if (highlight) views.mirrors.push_back({arms, *highlight});
  }
  return views;
}

// Example failure is a sign or an axis that the bundle and the simulated lens do not share.
TEST(FitGeometry, FindsThePlantedRigInImages) {
  const SimConfig truth = PlantedTruth();
  const Views views = Photographed(truth, 1);
  EXPECT_GE(views.boards.size(), 20u);
  EXPECT_GE(views.mirrors.size(), 20u);
  const auto fit = FitGeometry(Belief(BelievedRig()), kBoard, views.boards, views.mirrors);
  ASSERT_TRUE(fit) << fit.error().message;
  const auto planted = PlantedValues(truth);
  fmt::print("rms {:.4f} px, {:.4f} px; views {}, {}\n", fit->board_rms, fit->mirror_rms,
             fit->board_views, fit->mirror_views);
  for (int i = 0; i < kGeometryUnknowns; ++i) {
    const MeasuredValue& found = fit->unknowns[i];
    fmt::print("{:28} {:12.6f} planted {:12.6f} sigma {:10.2e} z {:6.2f}\n", kGeometryNames[i],
               found.value, planted[i], found.sigma, (found.value - planted[i]) / found.sigma);
    if (i != kRadialDistortion) {
      EXPECT_NEAR(found.value, planted[i], 5 * found.sigma) << kGeometryNames[i];
    }
  }
  EXPECT_LT(fit->board_rms, 0.1);
  EXPECT_TRUE(fit->left_out.empty());
}

// Corners and highlights as the simulated lens sees them, with noise of so many pixels: no images.
Views Synthetic(const SimConfig& truth, std::uint64_t seed, double noise) {
  RigConfig rig = BelievedRig();
  Random random(seed, 7);
  Views views;
  const auto blurred = [&](const Eigen::Vector2d& at) {
    const double x = random.Normal();
    return Eigen::Vector2d(at + noise * Eigen::Vector2d(x, random.Normal()));
  };
  const auto planted = PlantedValues(truth);
  for (const ArmAngles& arms : BoardPoses(rig)) {
    BoardView view{arms, {}};
    for (const auto& corner : ProjectCorners(planted, Belief(rig), kBoard, arms)) {
      view.corners.push_back(blurred(corner));
    }
    views.boards.push_back(view);
  }
  for (const ArmAngles& arms : MirrorPoses(rig)) {
    views.mirrors.push_back({arms, blurred(ProjectHighlight(planted, Belief(rig), arms))});
  }
  return views;
}

Result<GeometryFit> Fit(const Views& views) {
  return FitGeometry(Belief(BelievedRig()), kBoard, views.boards, views.mirrors);
}

// z-scores of all unknowns over so many seeds: their deviation is 1 within `each` for each unknown
// and `together` for all.
void ExpectStandardScores(int seeds, double each, double together) {
  const SimConfig truth = PlantedTruth();
  const auto planted = PlantedValues(truth);
  std::array<double, kGeometryUnknowns> squares{};
  double all = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto fit = Fit(Synthetic(truth, seed, 0.05));
    ASSERT_TRUE(fit) << fit.error().message;
    for (int i = 0; i < kGeometryUnknowns; ++i) {
      if (i == kRadialDistortion) continue;
      const double z = (fit->unknowns[i].value - planted[i]) / fit->unknowns[i].sigma;
      squares[i] += z * z / seeds;
      all += z * z / (seeds * (kGeometryUnknowns - 1));
    }
  }
  for (int i = 0; i < kGeometryUnknowns; ++i) {
    if (i == kRadialDistortion) continue;
    fmt::print("{:28} z {:.2f}\n", kGeometryNames[i], std::sqrt(squares[i]));
    EXPECT_NEAR(std::sqrt(squares[i]), 1, each) << kGeometryNames[i];
  }
  fmt::print("all {:.3f}\n", std::sqrt(all));
  EXPECT_NEAR(std::sqrt(all), 1, together);
}

// Example failure is a covariance of another weighting than the fit's.
TEST(FitGeometry, UncertaintiesAreRightOverSeeds) { ExpectStandardScores(12, 0.7, 0.2); }

// The figures of docs/results.md; takes a minute.
TEST(FitGeometry, DISABLED_UncertaintiesAreRightOverSixtySeeds) {
  ExpectStandardScores(60, 0.35, 0.1);
}

TEST(FitGeometry, TellsADistortedLensFromAStraightOne) {
  SimConfig truth = PlantedTruth();
  truth.radial_distortion = -0.2;
  const auto fit = Fit(Synthetic(truth, 5, 0.03));
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->distorted);
  EXPECT_NEAR((*fit)[kRadialDistortion], -0.2, 4 * fit->unknowns[kRadialDistortion].sigma);
  const auto straight = Fit(Synthetic(PlantedTruth(), 5, 0.03));
  ASSERT_TRUE(straight);
  EXPECT_FALSE(straight->distorted);
  EXPECT_EQ((*straight)[kRadialDistortion], 0);
}

// Someone pushed the board while one image was taken.
TEST(FitGeometry, NamesAndLeavesOutAViewThatDoesNotFit) {
  Views views = Synthetic(PlantedTruth(), 6, 0.03);
  for (Eigen::Vector2d& corner : views.boards[3].corners) corner += Eigen::Vector2d(4, -2);
  const auto fit = Fit(views);
  ASSERT_TRUE(fit) << fit.error().message;
  ASSERT_EQ(fit->left_out.size(), 1u);
  EXPECT_TRUE(fit->left_out[0].starts_with("board view 4: ")) << fit->left_out[0];
  EXPECT_NEAR((*fit)[kCameraElevationOffset], PlantedTruth().axis_offset[3], 1e-4);
}

TEST(FitGeometry, FindsTheCameraAloneWithoutAMirror) {
  Views views = Synthetic(PlantedTruth(), 7, 0.03);
  views.mirrors.clear();
  const auto fit = Fit(views);
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->has_light);
  EXPECT_EQ(fit->unknowns[kLightAzimuthOffset].sigma, 0);
  EXPECT_NEAR((*fit)[kCameraDistance], 0.507, 5 * fit->unknowns[kCameraDistance].sigma);
}

TEST(FitGeometry, RefusesTooFewViews) {
  Views views = Synthetic(PlantedTruth(), 8, 0.03);
  views.boards.resize(4);
  const auto few = Fit(views);
  ASSERT_FALSE(few);
  EXPECT_EQ(few.error().message, "4 usable views of the board; 6 are needed");
  views = Synthetic(PlantedTruth(), 8, 0.03);
  views.mirrors.resize(2);
  EXPECT_EQ(Fit(views).error().message, "2 usable views of the mirror; 5 are needed");
}

}  // namespace
}  // namespace gonio
