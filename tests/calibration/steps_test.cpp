// SPDX-License-Identifier: Apache-2.0
// What was planted in a simulated camera is found again, within what the steps say they know.

#include "acquisition/calibration/steps.h"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "acquisition/calibration/step_frames.h"
#include "tests/calibration/imperfect_rig.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

// Example failure: a step that reads its numbers from the rig file, which is wrong on purpose.
TEST(Steps, FindThePlantedSensor) {
  const Calibrations found = LoadFrom(CalibratedFolder());
  const SimConfig truth = ImperfectTruth();
  ASSERT_EQ(found.files.size(), 6u);
  // The bend of 3 % at full scale makes the noise of bright frames smaller: K comes out higher.
  EXPECT_NEAR(found.sensor->gain.value, truth.electrons_per_count,
              4 * found.sensor->gain.sigma + 0.04 * truth.electrons_per_count);
  EXPECT_FALSE(found.sensor->linearity.is_identity());
  const double middle = 0.5 * ImperfectRig().camera.full_scale;
  EXPECT_NEAR(found.sensor->linearity.Factor(0.9 * 4031)->value /
                  found.sensor->linearity.Factor(middle)->value,
              (1 - truth.nonlinearity * 0.5) / (1 - truth.nonlinearity * 0.9), 0.012);

  const SiteImage& rate = found.dark->fits.front().rate;
  const double typical = Median({rate.begin(), rate.end()});
  EXPECT_NEAR(typical, truth.dark_current / truth.electrons_per_count, 0.5);

  const double hot = static_cast<double>(found.bad_pixels->hot) /
                     static_cast<double>(found.bad_pixels->mask.size());
  EXPECT_NEAR(hot, truth.hot_pixels, 0.004);

  const RobustSpread pattern = RobustSpreadOf(found.flat->response);
  EXPECT_NEAR(pattern.sigma, truth.prnu, 0.2 * truth.prnu);
}

// Of a sensor that does not bend, within stated sigma.
TEST(Steps, FindGainAndReadNoiseOfAStraightSensor) {
  const TempDir dir;
  SimConfig truth = ImperfectTruth();
  truth.nonlinearity = 0;
  StepOptions options;
  options.folder = dir.path();
  ASSERT_TRUE(RunStep(CalibrateDarks, Trap(), options, 7, truth).ok());
  ASSERT_TRUE(RunStep(CalibratePhotonTransfer, WhiteTile(), options, 8, truth).ok());
  const SensorCalibration sensor = *LoadFrom(dir.path()).sensor;
  EXPECT_NEAR(sensor.gain.value, truth.electrons_per_count, 3.5 * sensor.gain.sigma);
  EXPECT_NEAR(sensor.read_noise.value, truth.read_noise, 3.5 * sensor.read_noise.sigma);
  EXPECT_LT(sensor.gain.relative(), 0.006);
  EXPECT_TRUE(sensor.linearity.is_identity());
}

// R is what the truth says in electrons of the calibration's own gain.
TEST(Steps, FindTheResponsivity) {
  const Calibrations found = LoadFrom(CalibratedFolder());
  const SimConfig truth = ImperfectTruth();
  const double gain = found.sensor->gain.value / truth.electrons_per_count;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const MeasuredValue& r = found.responsivity->responsivity[c];
    EXPECT_GT(r.relative(), 0.005) << "the certificate's half per cent is in it";
    // The straight line of the linearity table has a slope of its own, which R takes in.
    EXPECT_NEAR(r.value / (gain * truth.responsivity[static_cast<int>(c)]), 1, 0.035) << c;
    const StrayLight& stray = (*found.stray)[c];
    EXPECT_NEAR(stray.background.value / gain, truth.stray_light,
                5 * stray.background.sigma + 0.03 * truth.stray_light);
  }
}

// Example failure is a step that believes the encoders of a rig whose offsets are known.
TEST(Steps, SeeWhereTheArmsTrulyAre) {
  RigConfig config = ImperfectRig();
  SimConfig truth = ImperfectTruth();
  config.axis_offsets = {0, 0.02, 0, 0.01};
  truth.axis_offset = config.axis_offsets;
  SimulatedRig rig(WhiteTile(), 1, config, truth);
  const TempDir dir;
  StepOptions options;
  options.folder = dir.path() / "cal";
  StepFrames step({rig.rig, rig.devices, rig.clock}, options, "flat");
  const auto there = step.GoTo(step.Pose());
  ASSERT_TRUE(there.ok()) << there.error().message;
  const DirectionPair& seen = step.regions().front().directions;
  EXPECT_NEAR(std::acos(seen.cos_theta_i()), RadFromDeg(45), 1e-3);
  EXPECT_NEAR(step.arms()[kLightElevation], RadFromDeg(45), 1e-3);
}

TEST(Steps, NameTheCommandThatIsMissing) {
  const TempDir dir;
  StepOptions options;
  options.folder = dir.path() / "cal";
  options.standard = kStandardFile;
  try {
    (void)RunStep(CalibrateFlat, WhiteTile(), options);
    FAIL() << "must be refused";
  } catch (const ConfigError& e) {
    EXPECT_THAT(e.what(), HasSubstr("gonio calibrate darks"));
  }
}

TEST(Steps, RefusePosesOutOfReach) {
  StepOptions options;
  options.folder = CalibratedFolder();
  options.theta_i = RadFromDeg(30);
  options.theta_o = RadFromDeg(-30);  // where the light is
  const auto report = RunStep(CalibrateFlat, WhiteTile(), options);
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::kRefused);
}

int FramesIn(const fs::path& folder) {
  int frames = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    frames += entry.path().extension() == ".tiff";
  }
  return frames;
}

// A step that is stopped half-way takes only what is missing when it is started again, and ends as
// if nothing had been. Example failure: exposures that are metered anew, and differ.
TEST(Steps, GoOnWhereTheyWereStopped) {
  const TempDir dir;
  StepOptions options;
  options.folder = dir.path();
  options.frames = 4;
  std::stop_source stop;
  options.stop = stop.get_token();
  options.progress = [&](int done, int total, const std::string&) {
    EXPECT_EQ(total, 12);
    if (done == 5) stop.request_stop();
  };
  const auto stopped = RunStep(CalibrateDarks, Trap(), options);
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::kCancelled);
  EXPECT_EQ(FramesIn(dir.path() / "darks.frames"), 5);
  EXPECT_FALSE(fs::exists(dir.path() / "dark.yaml"));

  // One was being written when the power went.
  fs::remove(dir.path() / "darks.frames/frame-0005.yaml");
  options.stop = {};
  options.keep_frames = true;
  int frames = 0;
  const fs::file_time_type first = fs::last_write_time(dir.path() / "darks.frames/frame-0001.tiff");
  options.progress = [&](int, int, const std::string&) { ++frames; };
  const auto done = RunStep(CalibrateDarks, Trap(), options, 2);
  ASSERT_TRUE(done.ok()) << done.error().message;
  EXPECT_EQ(frames, 12);
  EXPECT_EQ(FramesIn(dir.path() / "darks.frames"), 12);
  EXPECT_EQ(fs::last_write_time(dir.path() / "darks.frames/frame-0001.tiff"), first);
  EXPECT_TRUE(fs::exists(dir.path() / "dark.yaml"));
}

// As above, by SIGKILL.
TEST(Steps, GoOnWhereTheyWereKilled) {
  const TempDir dir;
  StepOptions options;
  options.folder = dir.path();
  options.frames = 4;
  const pid_t child = ::fork();
  if (child == 0) {
    options.progress = [](int done, int, const std::string&) {
      if (done == 7) ::kill(::getpid(), SIGKILL);
    };
    (void)RunStep(CalibrateDarks, Trap(), options);
    ::_exit(0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(FramesIn(dir.path() / "darks.frames"), 7);
  const auto done = RunStep(CalibrateDarks, Trap(), options);
  ASSERT_TRUE(done.ok()) << done.error().message;
  EXPECT_TRUE(fs::exists(dir.path() / "dark.yaml"));
  EXPECT_FALSE(fs::exists(dir.path() / "darks.frames"));
}

TEST(Steps, RefuseFramesOfOtherSettingsUnlessToldToBeginAnew) {
  const TempDir dir;
  StepOptions options;
  options.folder = dir.path();
  options.frames = 2;
  options.keep_frames = true;
  ASSERT_TRUE(RunStep(CalibrateDarks, Trap(), options).ok());
  options.frames = 3;
  try {
    (void)RunStep(CalibrateDarks, Trap(), options);
    FAIL() << "must be refused";
  } catch (const ConfigError& e) {
    EXPECT_THAT(e.what(), HasSubstr("frames is 3, was 2; --again starts over"));
  }
  options.again = true;
  options.keep_frames = false;
  ASSERT_TRUE(RunStep(CalibrateDarks, Trap(), options).ok());
  EXPECT_FALSE(fs::exists(dir.path() / "darks.frames"));
}

}  // namespace
}  // namespace gonio
