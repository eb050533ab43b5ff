// SPDX-License-Identifier: Apache-2.0
#include "acquisition/rig.h"

#include <gmock/gmock.h>

#include "acquisition/kinematics.h"
#include "acquisition/time_estimate.h"
#include "core/file.h"
#include "tests/acquisition/simulated_rig.h"

namespace gonio {
namespace {

// The default file with one piece of text replaced.
std::string Edited(const std::string& from, const std::string& to) {
  std::string text = ReadTextFile(kSimRigFile);
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string ComplaintAbout(const std::string& text) {
  try {
    const ConfigNode root = ConfigNode::Parse(text, "rig.yaml");
    ReadRig(root, text);
    ReadSim(root);
    root.RefuseUnknownKeys();
  } catch (const ConfigError& e) {
    // Without the line number, which moves with every comment added to the file.
    const std::string message = e.what();
    return message.substr(message.find(": ") + 2);
  }
  return "none";
}

TEST(ReadRig, ReadsTheDefaultFileInRadiansAndSeconds) {
  const ConfigNode root = ConfigNode::Load(kSimRigFile);
  const RigConfig rig = ReadRig(root, "the text");
  ReadSim(root);
  root.RefuseUnknownKeys();
  EXPECT_EQ(rig.text, "the text");
  EXPECT_TRUE(rig.simulated);
  EXPECT_DOUBLE_EQ(rig.axes[kLightAzimuth].min_position, RadFromDeg(-185));
  EXPECT_DOUBLE_EQ(rig.axes[kCameraElevation].max_position, kPi / 2);
  EXPECT_DOUBLE_EQ(rig.axes[kCameraAzimuth].max_speed, RadFromDeg(20));
  EXPECT_DOUBLE_EQ(rig.geometry.max_polar, RadFromDeg(86));
  EXPECT_DOUBLE_EQ(rig.motion.settle.count(), 0.5);
  EXPECT_EQ(rig.camera.layout, PixelLayout::kRgb);
  EXPECT_EQ(rig.radiometry.responsivity[1], 120e3);
  EXPECT_EQ(rig.dense_brackets, 3);
}

std::string LedsEdited(const std::string& from, const std::string& to) {
  std::string text = ReadTextFile(kLedRigFile);
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

constexpr const char* kColours = "colours: {red: 0, green: 1, blue: 2}";
constexpr const char* kWheel =
    "filter_wheel: {min_deg: 0, max_deg: 350, max_speed_deg_s: 90, acceleration_deg_s2: 180, "
    "tolerance_deg: 0.1, positions_deg: ";

TEST(ReadRig, ReadsTheColoursOfALight) {
  const RigConfig leds = ReadRig(ConfigNode::Load(kLedRigFile), "");
  EXPECT_TRUE(leds.by_colour);
  EXPECT_EQ(leds.colour_channels, (ColourChannels{0, 1, 2}));
  EXPECT_EQ(leds.colour_settle, Seconds(0.02));
  const std::string text =
      LedsEdited(kColours, kWheel + std::string("{red: 10, green: 130, blue: 250}}"));
  const RigConfig wheel = ReadRig(ConfigNode::Parse(text, "rig.yaml"), text);
  EXPECT_TRUE(wheel.by_colour);
  EXPECT_FALSE(wheel.colour_channels);
  EXPECT_NEAR(wheel.filter_wheel->positions[1], RadFromDeg(130), 1e-12);
  EXPECT_NEAR(wheel.filter_wheel->limits.max_speed, RadFromDeg(90), 1e-12);
  EXPECT_FALSE(DefaultRig().by_colour);
}

TEST(ReadRig, RefusesColoursThatMakeNoSense) {
  EXPECT_EQ(ComplaintAbout(LedsEdited("layout: mono ", "layout: rgb ")),
            "light.colours: camera.layout is rgb: such a camera tells colours apart by itself and "
            "wants white light; only one of layout mono is lit by one colour after the other");
  EXPECT_EQ(ComplaintAbout(LedsEdited("layout: mono ", "layout: bayer-rg ")).substr(0, 37),
            "light.colours: camera.layout is bayer");
  EXPECT_EQ(ComplaintAbout(LedsEdited(kColours, "colours: {red: 0, blue: 1}")),
            "light.colours.green: is missing");
  EXPECT_EQ(ComplaintAbout(LedsEdited(kColours, "colours: {red: 0, green: 1, blue: 0}")),
            "light.colours.blue: channel 0 is that of red");
  const auto wheel = [](const std::string& positions) {
    return ComplaintAbout(LedsEdited(kColours, kWheel + positions + "}"));
  };
  EXPECT_EQ(wheel("{red: 10, green: 130}"), "light.filter_wheel.positions_deg.blue: is missing");
  EXPECT_EQ(wheel("{red: 10, green: 130, blue: 351}"),
            "light.filter_wheel.positions_deg.blue: is outside min_deg .. max_deg, give or take "
            "approach_deg");
  EXPECT_EQ(wheel("{red: 10, green: 130, blue: 10.1}"),
            "light.filter_wheel.positions_deg.blue: is within tolerance_deg of red");
  EXPECT_EQ(ComplaintAbout(LedsEdited(kColours, kColours + std::string("\n  ") + kWheel +
                                                    "{red: 10, green: 130, blue: 250}}")),
            "light.filter_wheel: the light has colours already (light.colours)");
}

TEST(ReadRig, ReadsWhatAnImageSees) {
  const std::string text = ReadTextFile(kSimRigFile) + R"(
imaging:
  focal_length_px: 2000
  camera_distance_mm: 500
  light_distance_mm: 800
  patch_radius_mm: 5
  sample: {kind: cylinder, radius_mm: 30}
  samples_per_image: 4
)";
  const ConfigNode root = ConfigNode::Parse(text, "rig.yaml");
  const RigConfig rig = ReadRig(root, text);
  ReadSim(root);
  root.RefuseUnknownKeys();
  EXPECT_EQ(rig.imaging.focal_length, 2000);
  EXPECT_DOUBLE_EQ(rig.imaging.patch_radius, 0.005);
  EXPECT_EQ(rig.imaging.shape.kind, SampleShape::Kind::kCylinder);
  EXPECT_DOUBLE_EQ(rig.imaging.shape.radius, 0.03);
  EXPECT_EQ(rig.samples_per_image, 4);
  const auto complaint = [&](const std::string& from, const std::string& to) {
    std::string edited = text;
    edited.replace(edited.find(from), from.size(), to);
    try {
      ReadRig(ConfigNode::Parse(edited, "rig.yaml"), edited);
    } catch (const ConfigError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(complaint("samples_per_image: 4", "samples_per_image: 3"),
              testing::HasSubstr("samples_per_image: is 3, must be a power of two"));
  EXPECT_THAT(complaint("patch_radius_mm: 5", "patch_radius_mm: 500"),
              testing::HasSubstr("patch_radius_mm: reaches to the camera or the light"));
}

TEST(ReadRig, WhitePaperReachesTheTargetInAThirdOfASecond) {
  const RigConfig rig = DefaultRig();
  const double rate = 0.3 * rig.radiometry.responsivity[1] / rig.radiometry.electrons_per_count;
  const double exposure = rig.exposure.target_fraction * rig.camera.full_scale / rate;
  EXPECT_NEAR(exposure, 0.3, 0.05);
}

RigConfig Preset(const std::string& name) {
  const ConfigNode root =
      ConfigNode::Load(std::string(GONIO_SOURCE_DIR) + "/configs/rig-" + name + ".yaml");
  RigConfig rig = ReadRig(root, "");
  ReadSim(root);
  root.RefuseUnknownKeys();
  return rig;
}

class Presets : public testing::TestWithParam<const char*> {};

TEST_P(Presets, AreRead) { EXPECT_NO_THROW(Preset(GetParam())); }

INSTANTIATE_TEST_SUITE_P(ReadRig, Presets,
                         testing::Values("slow-stepper", "robot-arm", "fast-servo", "rt300s"));

TEST(ReadRig, PresetOfTheRt300sTakesItsClockedTimes) {
  const RigConfig rig = Preset("rt300s");
  const Kinematics kinematics(rig);
  const auto pose = [&](double incidence, double azimuth, double receiver) {
    const Seconds travel = kinematics.TravelTime(
        AnglesDeg(0, 60, 20, 40), AnglesDeg(0, 60 + incidence, 20 + azimuth, 40 + receiver));
    return (travel + rig.motion.settle + NominalExposing(rig)).count();
  };
  EXPECT_NEAR(pose(0, 0, 5), 2, 0.1);
  EXPECT_NEAR(pose(0, 10, 40), 27, 0.1);
  EXPECT_NEAR(pose(10, 10, 40), 72, 0.1);
}

struct BadRig {
  const char* from;
  const char* to;
  const char* complaint;
};

class BadRigs : public testing::TestWithParam<BadRig> {};

TEST_P(BadRigs, AreRefusedByKey) {
  EXPECT_EQ(ComplaintAbout(Edited(GetParam().from, GetParam().to)), GetParam().complaint);
}

INSTANTIATE_TEST_SUITE_P(
    ReadRig, BadRigs,
    testing::Values(
        BadRig{"version: 1", "version: 2", "version: is 2, must be between 1 and 1"},
        BadRig{"name: simulated lab stage", "name: \"\"", "name: must not be empty"},
        BadRig{"kind: simulated", "kind: imagined",
               "kind: is \"imagined\", must be one of simulated, real"},
        BadRig{"kind: four-axis-arms", "kind: dome",
               "geometry.kind: is \"dome\", must be one of four-axis-arms, turntable, "
               "tilting-sample, four-axis"},
        BadRig{"min_separation_deg: 3", "min_separation_deg: -3",
               "geometry.min_separation_deg: is -3, must be between 0 and 90"},
        BadRig{"max_polar_deg: 86", "max_polar_deg: 90",
               "geometry.max_polar_deg: is 90, must be between 1 and 89.9"},
        BadRig{"min_deg: -185", "min_deg: 185",
               "axes.light_azimuth.max_deg: is 185, must be > min_deg = 185"},
        BadRig{"max_deg: 185", "max_deg: 400",
               "axes.light_azimuth.max_deg: is 400, must be between -360 and 360"},
        BadRig{"min_deg: 2\n", "min_deg: -2\n",
               "axes.light_elevation.min_deg: is -2, must be between 0 and 90"},
        BadRig{"min_deg: 2\n    max_deg: 90", "min_deg: 2\n    max_deg: 1.5",
               "axes.light_elevation.max_deg: is 1.5, must be > min_deg = 2"},
        BadRig{"max_speed_deg_s: 20", "max_speed_deg_s: 0",
               "axes.light_azimuth.max_speed_deg_s: is 0, must be > 0"},
        BadRig{"acceleration_deg_s2: 40", "acceleration_deg_s2: -1",
               "axes.light_azimuth.acceleration_deg_s2: is -1, must be > 0"},
        BadRig{"tolerance_deg: 0.05", "tolerance_deg: fine",
               "axes.light_azimuth.tolerance_deg: is \"fine\", must be a finite number"},
        BadRig{"tolerance_deg: 0.05", "tolerance_deg: 0.05\n    approach_deg: 30",
               "axes.light_azimuth.approach_deg: is 30, must be between -20 and 20"},
        BadRig{"min_deg: 2\n    max_deg: 90",
               "min_deg: 88.5\n    max_deg: 90\n    approach_deg: 1.5",
               "axes.light_elevation.approach_deg: leaves no room between min_deg and max_deg"},
        BadRig{"kind: simulated", "kind: real", "axes.light_azimuth.device: is missing"},
        BadRig{"  camera_azimuth:", "  camera_azimut:", "axes.camera_azimuth: is missing"},
        BadRig{"settle_s: 0.5", "settle_s: -0.5", "motion.settle_s: is -0.5, must be >= 0"},
        BadRig{"home_limit_s: 120", "home_limit_s: 0", "motion.home_limit_s: is 0, must be > 0"},
        BadRig{"retries: 2", "retries: 2.5", "motion.retries: is 2.5, must be a whole number"},
        BadRig{"level: 1.0", "level: 0", "light.level: is 0, must be between 0.001 and 1"},
        BadRig{"width_px: 8", "width_px: 0", "camera.width_px: is 0, must be between 1 and 16384"},
        BadRig{"full_scale_counts: 4095", "full_scale_counts: 70000",
               "camera.full_scale_counts: is 70000, must be between 255 and 65535"},
        BadRig{"max_exposure_s: 10", "max_exposure_s: 1.0e-5",
               "camera.max_exposure_s: is 1e-05, must be > min_exposure_s = 2e-05"},
        BadRig{"readout_s: 0.03", "readout_s: -1", "camera.readout_s: is -1, must be >= 0"},
        BadRig{"target_fraction: 0.6", "target_fraction: 1.2",
               "exposure.target_fraction: is 1.2, must be between 0.05 and 0.95"},
        BadRig{"min_fraction: 0.005", "min_fraction: 0.5",
               "exposure.min_fraction: is 0.5, must be <= half of target_fraction = 0.6"},
        BadRig{"soft_limit_s: 1", "soft_limit_s: 0", "exposure.soft_limit_s: is 0, must be > 0"},
        BadRig{"max_frames: 8", "max_frames: 0",
               "exposure.max_frames: is 0, must be between 1 and 100"},
        BadRig{"responsivity: [100.0e+3, 120.0e+3, 80.0e+3]", "responsivity: [1, 2]",
               "radiometry.responsivity: must be a list of 3 numbers"},
        BadRig{"responsivity: [100.0e+3", "responsivity: [0",
               "radiometry.responsivity: holds 0, must be > 0"},
        BadRig{"electrons_per_count: 4", "electrons_per_count: 0",
               "radiometry.electrons_per_count: is 0, must be > 0"},
        BadRig{"tolerance_deg: 0.05", "tolerance_deg: 0.05\n    move_overhead_s: -1",
               "axes.light_azimuth.move_overhead_s: is -1, must be >= 0"},
        BadRig{"dense_brackets: 3", "dense_brackets: 0",
               "time.dense_brackets: is 0, must be between 1 and 100"},
        BadRig{"repeatability_deg: 0.005", "repeatability_deg: 5",
               "simulation.repeatability_deg: is 5, must be between 0 and 1"},
        BadRig{"light_drift_per_hour: 0.01", "light_drift_per_hour: 1",
               "simulation.light_drift_per_hour: is 1, must be between -0.2 and 0.2"},
        BadRig{"shot_noise: true", "shot_noise: yes",
               "simulation.shot_noise: is \"yes\", must be true or false"},
        BadRig{"shot_noise: true", "shut_noise: true", "simulation.shut_noise: is not a known key"},
        BadRig{"settle_s:", "setle_s: 1\n  settle_s:", "motion.setle_s: is not a known key"}));

TEST(ReadRig, NamesFileAndLine) {
  try {
    ReadRig(ConfigNode::Parse("version: 1\nname: x\nkind: imagined\n", "rig.yaml"), "");
    FAIL() << "no complaint";
  } catch (const ConfigError& e) {
    EXPECT_STREQ(e.what(), "rig.yaml:3: kind: is \"imagined\", must be one of simulated, real");
  }
}

}  // namespace
}  // namespace gonio
