// SPDX-License-Identifier: Apache-2.0
#include "acquisition/geometry_calibration/target_session.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "acquisition/geometry_calibration/geometry_file.h"
#include "acquisition/image_regions.h"
#include "sim/sim_rig.h"
#include "tests/core/temp_dir.h"
#include "tests/geometry/planted.h"

namespace gonio {
namespace {

// A simulated rig that is wrong about itself, with a target on its stage.
class Bench {
 public:
  explicit Bench(SimTarget::Kind kind) : rig(BelievedRig()) {
    rig.camera.full_scale = 4095;
    rig.camera.min_exposure = Seconds(2e-5);
    rig.camera.max_exposure = Seconds(10);
    SimConfig truth = PlantedTruth();
    truth.target.kind = kind;
    truth.target.columns = kBoard.columns;
    truth.target.rows = kBoard.rows;
    truth.target.square = kBoard.square;
    truth.encoder_resolution = RadFromDeg(0.002);
    truth.repeatability = RadFromDeg(0.005);
    SimDevices sim = MakeSimDevices(
        truth, {.axes = rig.axes, .camera = rig.camera, .imaging = rig.imaging}, grey, clock, 1);
    devices = {.axes = std::move(sim.axes),
               .camera = std::move(sim.camera),
               .light = std::move(sim.light),
               .monitor = std::move(sim.monitor)};
  }
  TargetSession session() { return {rig, devices, clock}; }

  const AnalyticBrdf grey{"grey", {Lambert{}}};
  ManualClock clock;
  RigConfig rig;
  Devices devices;
};

// Angle between where a part of the image is said to be seen from and lit from, and the truth
// [rad]: the mean over the parts of one pose, of the two the larger.
double DirectionError(const RigConfig& rig, const ArmAngles& encoders) {
  ArmAngles said = encoders;
  SimArms truly = encoders;
  for (int i = 0; i < kAxes; ++i) {
    said[i] += rig.axis_offsets[i];
    truly[i] += PlantedTruth().axis_offset[i];
  }
  Imaging imaging = rig.imaging;
  imaging.patch_radius = 0.02;
  const SimOptics optics(PlantedTruth(), BelievedRig().imaging, kWidth, kHeight);
  double sum = 0;
  const auto regions = RegionsOf(imaging, said, kWidth, kHeight, rig.geometry.max_polar, 64);
  for (const ImageRegion& region : regions) {
    Eigen::Vector3d wi = Eigen::Vector3d::Zero();
    Eigen::Vector3d wo = Eigen::Vector3d::Zero();
    for (const std::uint32_t pixel : region.pixels) {
      const auto view = optics.See(truly, pixel % kWidth, pixel / kWidth);
      wi += view->local.wi;
      wo += view->local.wo;
    }
    sum += std::max(AngleBetween(wi.normalized(), region.directions.wi),
                    AngleBetween(wo.normalized(), region.directions.wo));
  }
  return sum / static_cast<double>(regions.size());
}

// The whole way: arms move, images are taken, the fit is written, read and used. Example failure is
// a calibration that is applied with the wrong sign: directions would be twice as wrong as before.
TEST(TargetSession, ACalibratedRigKnowsItsDirections) {
  Bench with_board(SimTarget::Kind::kCheckerboard);
  auto boards = PhotographBoard(with_board.session(), kBoard);
  ASSERT_TRUE(boards) << boards.error().message;
  Bench with_mirror(SimTarget::Kind::kMirror);
  auto mirrors = PhotographMirror(with_mirror.session());
  ASSERT_TRUE(mirrors) << mirrors.error().message;
  EXPECT_EQ(with_mirror.devices.light->Level().value(), 0);

  const TempDir dir;
  const TargetViews taken{kBoard, "simulated", *boards, *mirrors};
  WriteViews(dir.path() / kViewsFile, taken);
  const TargetViews views = ReadViews(dir.path() / kViewsFile);
  const auto fit = FitGeometry(Belief(BelievedRig()), views.board, views.boards, views.mirrors);
  ASSERT_TRUE(fit) << fit.error().message;

  RigConfig calibrated = BelievedRig();
  UseGeometry(*fit, calibrated);
  const ArmAngles pose = {RadFromDeg(20), RadFromDeg(50), RadFromDeg(170), RadFromDeg(60)};
  const double before = DirectionError(BelievedRig(), pose);
  const double after = DirectionError(calibrated, pose);
  fmt::print("directions: {:.4f} deg before, {:.5f} deg after, said {:.5f} deg\n",
             DegFromRad(before), DegFromRad(after), DegFromRad(*calibrated.sigma_of_directions));
  EXPECT_GT(before, RadFromDeg(0.2));
  EXPECT_LT(after, RadFromDeg(0.01));
}

TEST(TargetSession, SaysThatTheTargetIsNotThere) {
  Bench bench(SimTarget::Kind::kMirror);
  const auto boards = PhotographBoard(bench.session(), kBoard);
  ASSERT_FALSE(boards);
  EXPECT_EQ(boards.error().message, "the board was seen in 0 of 24 views; 6 are needed");
}

TEST(TargetSession, SaysThatTheArmsCannotGetAround) {
  Bench bench(SimTarget::Kind::kCheckerboard);
  bench.rig.axes[kCameraElevation].max_position = RadFromDeg(20);
  const auto boards = PhotographBoard(bench.session(), kBoard);
  ASSERT_FALSE(boards);
  EXPECT_EQ(boards.error().message,
            "only 0 poses of the board are within the arms' limits; 6 are needed");
}

TEST(ReadViews, RefusesWhatIsDamaged) {
  const TempDir dir;
  std::ofstream(dir.path() / kViewsFile) << "{\"version\": 1, \"kind\": \"geometry-views\"";
  EXPECT_THROW(ReadViews(dir.path() / kViewsFile), ConfigError);
}

}  // namespace
}  // namespace gonio
