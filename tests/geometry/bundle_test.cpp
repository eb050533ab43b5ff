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
    const Estimate& found = fit->unknowns[i];
    fmt::print("{:28} {:12.6f} planted {:12.6f} sigma {:10.2e} z {:6.2f}\n", kGeometryNames[i],
               found.value, planted[i], found.sigma, (found.value - planted[i]) / found.sigma);
    if (i != kRadialDistortion) {
      EXPECT_NEAR(found.value, planted[i], 5 * found.sigma) << kGeometryNames[i];
    }
  }
  EXPECT_LT(fit->board_rms, 0.1);
  EXPECT_TRUE(fit->left_out.empty());
}

}  // namespace
}  // namespace gonio
