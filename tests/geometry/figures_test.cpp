// SPDX-License-Identifier: Apache-2.0
// The figures of docs/results.md, "Geometry": takes minutes, so it runs only when asked for.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/geometry/planted.h"

namespace gonio {
namespace {

constexpr int kSeeds = 50;

// Images of one target at all poses, rendered once: seeds differ in their noise.
class Series {
 public:
  Series(SimTarget::Kind kind, const std::vector<ArmAngles>& poses)
      : poses_(poses),
        imager_(Mounted(kind), BelievedRig().imaging, kWidth, kHeight, Random(1, 9)) {
    const bool mirror = kind == SimTarget::Kind::kMirror;
    readout_ = {.exposure = mirror ? Seconds(2e-5) : Seconds(0.2),
                .gain_db = 0,
                .black_level = 64,
                .layout = PixelLayout::kMono,
                .full_scale = 4095};
    for (const ArmAngles& pose : poses_) {
      SimView view{.arms = pose, .readout = readout_};
      for (int i = 0; i < kAxes; ++i) view.arms[i] += PlantedTruth().axis_offset[i];
      electrons_.push_back(imager_.See(view, grey_));
      electrons_.back() *= readout_.exposure.count();
    }
  }

  Frame Take(std::size_t pose) { return imager_.Read(electrons_[pose], readout_); }
  const std::vector<ArmAngles>& poses() const { return poses_; }

 private:
  static SimConfig Mounted(SimTarget::Kind kind) {
    SimConfig truth = PlantedTruth();
    truth.target.kind = kind;
    truth.target.columns = kBoard.columns;
    truth.target.rows = kBoard.rows;
    truth.target.square = kBoard.square;
    return truth;
  }

  const std::vector<ArmAngles> poses_;
  const AnalyticBrdf grey_{"grey", {Lambert{}}};
  SimImager imager_;
  SimReadout readout_;
  std::vector<SimImage> electrons_;
};

TEST(GeometryFigures, DISABLED_ZScoresOfImagesOverSeeds) {
  const RigConfig rig = BelievedRig();
  Series board(SimTarget::Kind::kCheckerboard, BoardPoses(rig));
  Series mirror(SimTarget::Kind::kMirror, MirrorPoses(rig));
  const auto planted = PlantedValues(PlantedTruth());
  std::array<double, kGeometryUnknowns> squares{};
  std::array<double, kGeometryUnknowns> sigmas{};
  std::array<double, kGeometryUnknowns> errors{};
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::vector<BoardView> boards;
    for (std::size_t i = 0; i < board.poses().size(); ++i) {
      const auto near = PredictCorners(Belief(rig), kBoard, board.poses()[i]);
      const auto corners = FindCorners(board.Take(i), 4095, kBoard, near);
      if (corners) boards.push_back({board.poses()[i], *corners});
    }
    std::vector<MirrorView> mirrors;
    for (std::size_t i = 0; i < mirror.poses().size(); ++i) {
      const auto at = FindHighlight(mirror.Take(i), 4095);
      if (at) mirrors.push_back({mirror.poses()[i], *at});
    }
    const auto fit = FitGeometry(Belief(rig), kBoard, boards, mirrors);
    ASSERT_TRUE(fit) << fit.error().message;
    for (int i = 0; i < kGeometryUnknowns; ++i) {
      const double error = fit->unknowns[i].value - planted[i];
      errors[i] += error * error / kSeeds;
      sigmas[i] += fit->unknowns[i].sigma / kSeeds;
      if (i != kRadialDistortion) {
        squares[i] += std::pow(error / fit->unknowns[i].sigma, 2) / kSeeds;
      }
    }
    if (seed % 10 == 9) fmt::print("{} seeds\n", seed + 1);
  }
  double all = 0;
  for (int i = 0; i < kGeometryUnknowns; ++i) {
    fmt::print("{:28} planted {:11.6f} rms error {:9.2e} sigma {:9.2e} z {:.2f}\n",
               kGeometryNames[i], planted[i], std::sqrt(errors[i]), sigmas[i],
               std::sqrt(squares[i]));
    all += squares[i] / (kGeometryUnknowns - 1);
  }
  fmt::print("all z {:.3f}\n", std::sqrt(all));
  EXPECT_NEAR(std::sqrt(all), 1, 0.2);
}

}  // namespace
}  // namespace gonio
