// SPDX-License-Identifier: Apache-2.0
// A mono camera with imperfections in front of three LEDs, and its calibration.

#include <gmock/gmock.h>

#include <cmath>

#include "acquisition/bracket_check.h"
#include "acquisition/calibration/calibration_status.h"
#include "acquisition/radiometry.h"
#include "acquisition/radiometry/frame_file.h"
#include "tests/calibration/imperfect_rig.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kLeds = "simulated, red, green and blue";

RigConfig LedImperfectRig() {
  RigConfig rig = ImperfectRig();
  rig.camera.layout = PixelLayout::kMono;
  rig.by_colour = true;
  rig.colour_channels = ColourChannels{0, 1, 2};
  return rig;
}

SensorFormat MonoFormat() {
  SensorFormat format = ImperfectFormat();
  format.layout = PixelLayout::kMono;
  return format;
}

Result<StepReport> RunLedStep(StepFunction step, const Brdf& mounted, StepOptions options) {
  SimulatedRig rig(mounted, 1, LedImperfectRig(), ImperfectTruth());
  options.now = kToday;
  return step({rig.rig, rig.devices, rig.clock}, options);
}

const fs::path& LedFolder() {
  static const TempDir dir;
  static const fs::path folder = [] {
    StepOptions options;
    options.folder = dir.path() / "cal";
    options.standard = kStandardFile;
    const auto expect = [&](StepFunction step, const Brdf& mounted) {
      const auto report = RunLedStep(step, mounted, options);
      EXPECT_TRUE(report.ok()) << report.error().message;
    };
    expect(CalibrateDarks, Trap());
    expect(CalibratePhotonTransfer, WhiteTile());
    expect(CalibrateFlat, WhiteTile());
    expect(CalibrateStrayLight, Trap());
    expect(CalibrateStandard, WhiteTile());
    return options.folder;
  }();
  return folder;
}

Calibrations Load(const fs::path& folder, const std::string& light = kLeds) {
  CalibrationPolicy policy;
  policy.folder = folder;
  return LoadCalibrations(policy, MonoFormat(), kToday, light);
}

std::string Refusal(const fs::path& folder, const std::string& light,
                    const SensorFormat& format = MonoFormat()) {
  CalibrationPolicy policy;
  policy.folder = folder;
  try {
    (void)LoadCalibrations(policy, format, kToday, light);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "none";
}

TEST(ColourCalibration, FindsWhatWasPlantedInEachColour) {
  const Calibrations found = Load(LedFolder());
  const SimConfig truth = ImperfectTruth();
  ASSERT_TRUE(found.dark && found.sensor && found.bad_pixels && found.colour_flats && found.stray &&
              found.responsivity);
  EXPECT_FALSE(found.flat);
  const double gain = found.sensor->gain.value / truth.electrons_per_count;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const MeasuredValue& r = found.responsivity->responsivity[c];
    EXPECT_NEAR(r.value / (gain * truth.responsivity[static_cast<int>(c)]), 1, 0.035) << c;
    EXPECT_NEAR((*found.stray)[c].background.value / gain, truth.stray_light,
                5 * (*found.stray)[c].background.sigma + 0.03 * truth.stray_light);
    const RobustSpread pattern = RobustSpreadOf((*found.colour_flats)[c].response);
    EXPECT_NEAR(pattern.sigma, truth.prnu, 0.25 * truth.prnu);
  }
  // Each is of its own frames.
  EXPECT_NE((*found.colour_flats)[0].response, (*found.colour_flats)[1].response);
}

TEST(ColourCalibration, MeasuresASampleWithinItsUncertainty) {
  const Rgb f_r(0.3, 0.05, 0.02);
  const FlatBrdf sample(f_r);
  SimulatedRig rig(sample, 9, LedImperfectRig(), ImperfectTruth());
  const Calibrations calibrations = Load(LedFolder());
  PoseMeasurer measurer(rig.rig, rig.devices, rig.clock, &calibrations.bad_pixels->mask);
  ASSERT_TRUE(measurer.Prepare({}).ok());
  const auto record = measurer.Measure(PairAt(25, 30, 60), std::nullopt, {}, 4);
  ASSERT_TRUE(record.ok()) << record.error().message;
  const auto reduced = Reduce(*record, rig.rig, calibrations);
  ASSERT_TRUE(reduced.ok()) << reduced.error().message;
  for (int c = 0; c < kChannels; ++c) {
    const double combined = reduced->front().budget.combined()[c];
    EXPECT_NEAR(reduced->front().sample.f_r[c], f_r[c], 4 * combined) << kChannelNames[c];
    EXPECT_LT(combined, 0.05 * f_r[c]) << kChannelNames[c];
  }
  // Frames in different colours say nothing of each other's exposures.
  PoseRecord one = *record;
  one.exposures.clear();
  for (const Exposure& e : record->exposures) {
    if (one.exposures.empty() || one.exposures.back().colour != e.colour) {
      one.exposures.push_back(e);
    }
  }
  ASSERT_EQ(one.exposures.size(), 3u);
  one.exposures[1].frame.exposure *= 2;
  const auto worst = LeastAgreement(one, rig.rig, calibrations);
  ASSERT_TRUE(worst.ok());
  EXPECT_FALSE(*worst);
}

// Example failure is the flat of white light before an LED, or LEDs that were plugged in otherwise.
TEST(ColourCalibration, OfAnotherLightIsRefused) {
  EXPECT_EQ(Refusal(LedFolder(), kLeds), "none");
  EXPECT_THAT(Refusal(LedFolder(), "other LEDs"),
              HasSubstr("flat-field.yaml: light is other LEDs, calibrated for simulated, red"));
  EXPECT_THAT(Refusal(LedFolder(), ""),
              HasSubstr("flat-field.yaml: light is one without colours, calibrated for sim"));
  EXPECT_THAT(Refusal(CalibratedFolder(), kLeds, ImperfectFormat()),
              HasSubstr("light is simulated, red, green and blue, calibrated for one without"));
  // What is the camera's own serves any light.
  const TempDir dir;
  for (const auto& entry : fs::directory_iterator(LedFolder())) {
    const std::string name = entry.path().filename();
    if (name.rfind("flat", 0) == 0 || name.rfind("stray", 0) == 0 || name.rfind("resp", 0) == 0) {
      continue;
    }
    fs::copy(entry.path(), dir.path());
  }
  EXPECT_EQ(Refusal(dir.path(), "other LEDs"), "none");
  EXPECT_EQ(Refusal(dir.path(), ""), "none");
}

TEST(ColourCalibration, IsCopiedAndReadAgainAndTold) {
  const TempDir dir;
  CopyCalibrations(Load(LedFolder()), dir.path() / "copy");
  const Calibrations copy = LoadCopies(dir.path() / "copy");
  EXPECT_EQ(copy.light, kLeds);
  ASSERT_TRUE(copy.colour_flats);
  CalibrationPolicy policy;
  policy.folder = LedFolder();
  for (const CalibrationStatus& status : StatusOf(policy, kToday)) {
    EXPECT_EQ(status.problem, "") << ToString(status.kind);
    if (status.kind == CalibrationKind::kFlatField) {
      EXPECT_THAT(status.numbers, testing::MatchesRegex("pattern .* %, pattern .* %, pattern .*"));
    }
  }
}

// Frames of each colour are kept apart; those of other LEDs are not taken for them.
TEST(ColourCalibration, AStepGoesOnWithFramesOfTheSameColour) {
  const TempDir dir;
  StepOptions options;
  options.folder = dir.path() / "cal";
  options.keep_frames = true;
  options.frames = 2;
  fs::copy(LedFolder(), options.folder, fs::copy_options::recursive);
  ASSERT_TRUE(RunLedStep(CalibrateFlat, WhiteTile(), options).ok());
  for (const LightColour colour : kLightColours) {
    const fs::path file = options.folder / "flat.frames" / ToString(colour) / "frame-0002.yaml";
    const auto stored = ReadFrameFile(file, MonoFormat());
    ASSERT_TRUE(stored) << file;
    EXPECT_EQ(stored->colour, colour);
  }
  ASSERT_TRUE(RunLedStep(CalibrateFlat, Trap(), options).ok()) << "no frame was taken anew";
}

}  // namespace
}  // namespace gonio
