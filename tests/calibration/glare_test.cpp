// SPDX-License-Identifier: Apache-2.0
// Glare of a simulated lens is found, and taken off.

#include <gmock/gmock.h>

#include "acquisition/radiometry.h"
#include "tests/calibration/imperfect_rig.h"

namespace gonio {
namespace {

constexpr double kGlare = 0.03;   // of the true mean, which the simulator adds
constexpr double kTrap = 0.004;   // m
constexpr double kPatch = 0.012;  // albedo of a dark patch in a white surround

// The camera of configs/sim-imperfect.yaml with a lens, 64 pixels each way; or a mono one before
// three LEDs.
RigConfig LensRig(bool leds = false) {
  RigConfig rig = ImperfectRig();
  rig.camera.width = rig.camera.height = 64;
  rig.imaging.focal_length = 2000;
  rig.imaging.camera_distance = 0.5;
  rig.imaging.light_distance = 0.8;
  rig.imaging.patch_radius = 0.6 * kTrap;
  if (leds) {
    rig.camera.layout = PixelLayout::kMono;
    rig.by_colour = true;
    rig.colour_channels = ColourChannels{0, 1, 2};
  }
  return rig;
}

SimConfig LensTruth() {
  SimConfig truth = ImperfectTruth();
  truth.veiling_glare = kGlare;
  truth.vignetting = 1;
  truth.defocus = 0.7;
  return truth;
}

SimConfig WithHole(double radius, double albedo) {
  SimConfig truth = LensTruth();
  truth.target.kind = SimTarget::Kind::kTrap;
  truth.target.hole = radius;
  truth.target.hole_albedo = albedo;
  return truth;
}

Result<StepReport> RunOnLens(StepFunction step, const Brdf& mounted,
                             const std::filesystem::path& folder, const SimConfig& truth,
                             std::uint64_t seed, bool leds = false) {
  SimulatedRig rig(mounted, seed, LensRig(leds), truth);
  StepOptions options;
  options.folder = folder;
  options.standard = kStandardFile;
  options.theta_i = RadFromDeg(45);
  options.theta_o = 0;
  options.trap_radius = kTrap;
  options.now = kToday;
  return step({rig.rig, rig.devices, rig.clock}, options);
}

void Expect(const Result<StepReport>& report) {
  ASSERT_TRUE(report.ok()) << report.error().message;
}

Calibrations Load(const std::filesystem::path& folder) {
  CalibrationPolicy policy;
  policy.folder = folder;
  SensorFormat format = ImperfectFormat();
  format.width = format.height = 64;
  return LoadCalibrations(policy, format, kToday);
}

// All steps, with glare or without.
void CalibrateLens(const std::filesystem::path& folder, bool glare, std::uint64_t seed) {
  Expect(RunOnLens(CalibrateDarks, Trap(), folder, LensTruth(), seed));
  Expect(RunOnLens(CalibratePhotonTransfer, WhiteTile(), folder, LensTruth(), seed + 1));
  Expect(RunOnLens(CalibrateFlat, WhiteTile(), folder, LensTruth(), seed + 2));
  Expect(RunOnLens(CalibrateStrayLight, Trap(), folder, LensTruth(), seed + 3));
  if (glare) Expect(RunOnLens(CalibrateGlare, Trap(), folder, WithHole(kTrap, 0), seed + 4));
  Expect(RunOnLens(CalibrateStandard, WhiteTile(), folder, LensTruth(), seed + 5));
}

struct LensCalibrations {
  Calibrations with, without;
};

const LensCalibrations& Both() {
  static const LensCalibrations both = [] {
    const TempDir dir;
    CalibrateLens(dir.path() / "with", true, 10);
    CalibrateLens(dir.path() / "without", false, 10);
    return LensCalibrations{Load(dir.path() / "with"), Load(dir.path() / "without")};
  }();
  return both;
}

// Example failure: a share of the bright field instead of the image's mean, which the hole dims.
TEST(Glare, IsFoundWithinItsError) {
  // Of the mean as it is measured, glare included.
  const double planted = kGlare / (1 + kGlare);
  for (const StrayLight& stray : *Both().with.stray) {
    EXPECT_GT(stray.glare.sigma, 0);
    EXPECT_LT(stray.glare.sigma, 0.002);
    EXPECT_NEAR(stray.glare.value, planted, 3.5 * stray.glare.sigma);
  }
  EXPECT_EQ((*Both().without.stray)[0].glare.value, 0);
  // The background stays what it was.
  EXPECT_EQ((*Both().with.stray)[1].background.value, (*Both().without.stray)[1].background.value);
}

// Of a mono camera before three LEDs.
TEST(Glare, IsFoundInEachColourOfTheLight) {
  const TempDir dir;
  const std::filesystem::path& folder = dir.path();
  Expect(RunOnLens(CalibrateDarks, Trap(), folder, LensTruth(), 20, true));
  Expect(RunOnLens(CalibratePhotonTransfer, WhiteTile(), folder, LensTruth(), 21, true));
  Expect(RunOnLens(CalibrateFlat, WhiteTile(), folder, LensTruth(), 22, true));
  Expect(RunOnLens(CalibrateStrayLight, Trap(), folder, LensTruth(), 23, true));
  Expect(RunOnLens(CalibrateGlare, Trap(), folder, WithHole(kTrap, 0), 24, true));
  CalibrationPolicy policy;
  policy.folder = folder;
  SensorFormat format = ImperfectFormat();
  format.width = format.height = 64;
  format.layout = PixelLayout::kMono;
  const Calibrations found =
      LoadCalibrations(policy, format, kToday, "simulated, red, green and blue");
  const double planted = kGlare / (1 + kGlare);
  for (const StrayLight& stray : *found.stray) {
    EXPECT_GT(stray.glare.sigma, 0);
    EXPECT_LT(stray.glare.sigma, 0.002);
    EXPECT_NEAR(stray.glare.value, planted, 3.5 * stray.glare.sigma);
  }
  // Each of its own frames.
  EXPECT_NE((*found.stray)[0].glare.value, (*found.stray)[2].glare.value);
}

struct Found {
  Rgb f_r = Rgb::Zero();
  Rgb systematic = Rgb::Zero();
};

// The patch in its white surround, a mean of some poses.
Found MeasurePatch(const Calibrations& calibrations) {
  RigConfig config = LensRig();
  Believe(calibrations, &config);
  Found found;
  constexpr int kSeeds = 6;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    SimulatedRig rig(WhiteTile(), 70 + seed, config, WithHole(kTrap, kPatch));
    PoseMeasurer measurer(rig.rig, rig.devices, rig.clock, &calibrations.bad_pixels->mask);
    EXPECT_TRUE(measurer.Prepare({}).ok());
    const auto record = measurer.Measure(PairAt(25, 30, 60), Rgb::Constant(0.3), {}, 4);
    EXPECT_TRUE(record.ok()) << record.error().message;
    const auto reduced = Reduce(*record, rig.rig, calibrations);
    EXPECT_TRUE(reduced.ok());
    found.f_r += reduced->front().sample.f_r / kSeeds;
    found.systematic = reduced->front().budget.systematic();
  }
  return found;
}

// A dark patch that the lens makes brighter by two thirds is what it is again.
TEST(Glare, IsTakenOffADarkPatch) {
  constexpr double kTruth = kPatch / kPi;
  const Found before = MeasurePatch(Both().without);
  const Found after = MeasurePatch(Both().with);
  for (int c = 0; c < kChannels; ++c) {
    EXPECT_GT(before.f_r[c] / kTruth, 2) << c;
    EXPECT_NEAR(after.f_r[c] / kTruth, 1, 3.5 * after.systematic[c] / kTruth + 0.01) << c;
    EXPECT_LT(after.systematic[c] / kTruth, 0.08) << c;
  }
}

TEST(Glare, StaysWhenStrayLightIsMeasuredAnew) {
  const TempDir dir;
  const auto folder = dir.path() / "cal";
  CalibrateLens(folder, true, 10);
  const double before = Load(folder).stray->at(0).glare.value;
  Expect(RunOnLens(CalibrateStrayLight, Trap(), folder, LensTruth(), 33));
  EXPECT_EQ(Load(folder).stray->at(0).glare.value, before);
}

TEST(Glare, RefusesATileWithoutATrap) {
  const TempDir dir;
  const auto folder = dir.path() / "cal";
  CalibrateLens(folder, false, 10);
  const auto report = RunOnLens(CalibrateGlare, WhiteTile(), folder, LensTruth(), 15);
  ASSERT_FALSE(report.ok());
  EXPECT_THAT(report.error().message, testing::HasSubstr("as bright"));
  StepOptions options;
  options.folder = CalibratedFolder();
  EXPECT_THROW((void)RunStep(CalibrateGlare, WhiteTile(), options), ConfigError);
}

}  // namespace
}  // namespace gonio
