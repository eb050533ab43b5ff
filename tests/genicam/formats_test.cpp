// SPDX-License-Identifier: Apache-2.0
// Counts, settings and refusals, end to end over GVCP and GVSP.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/pixel_unpacking.h"
#include "tests/genicam/gige_rig.h"
#include "tests/genicam/own_network.h"

namespace gonio {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class GenicamFormats : public testing::TestWithParam<const char*> {};

// Example failures are Mono12Packed read as Mono12p, a region that begins elsewhere, and a gain
// that was not sent.
TEST_P(GenicamFormats, ShowTheCountsOfTheRegionThatWasAskedFor) {
  GenicamSettings settings = DriverSettings();
  settings.pixel_format = GetParam();
  settings.offset_x = 8;
  settings.offset_y = 4;
  settings.gain_db = 6;
  settings.black_level = 16;
  GigeRig rig(settings);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  const PixelFormat* format = FindPixelFormat(GetParam());
  ASSERT_NE(format, nullptr);
  EXPECT_EQ(rig.driver().info().full_scale, format->full_scale());

  rig.device->SetTemperature(41.5);
  const auto frame = rig.driver().Capture(Seconds(0.004), {});
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame->layout, format->layout);
  EXPECT_DOUBLE_EQ(frame->exposure.count(), 0.004);
  EXPECT_DOUBLE_EQ(frame->gain_db, 6);
  EXPECT_DOUBLE_EQ(frame->black_level, 16);
  EXPECT_EQ(frame->temperature_c, 41.5);
  const GigeExposure expected{.exposure = Seconds(0.004),
                              .gain_db = 6,
                              .black_level = 16,
                              .x = 8,
                              .y = 4,
                              .width = 64,
                              .height = 48,
                              .layout = format->layout,
                              .full_scale = format->full_scale(),
                              .pixel_format = GetParam()};
  ASSERT_EQ(frame->counts.size(), expected.counts());
  for (std::size_t i = 0; i < frame->counts.size(); ++i) {
    ASSERT_EQ(frame->counts[i], GigeCount(expected, i)) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, GenicamFormats,
                         testing::Values("Mono8", "Mono10", "Mono12", "Mono16", "Mono10p",
                                         "Mono12p", "Mono12Packed", "BayerRG8", "BayerRG12",
                                         "BayerRG12p", "RGB8"),
                         [](const auto& each) { return std::string(each.param); });

TEST(GenicamCamera, SaysWhatItIsAndHowItIsSet) {
  GigeRig rig;
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  EXPECT_EQ(rig.driver().identity(),
            "Goniopilot, GigE double, serial GP0001, firmware 1.0, Mono12, 64 x 48 px at 0, 0, "
            "gain 0 dB, black level 0, trigger Software");
  EXPECT_DOUBLE_EQ(rig.driver().info().min_exposure.count(), 20e-6);
  EXPECT_DOUBLE_EQ(rig.driver().info().max_exposure.count(), 2);
}

// Example failure is a frame that carries the exposure asked for, not the one used.
TEST(GenicamCamera, ReportsTheExposureThatTheCameraMadeOfIt) {
  GigeRig rig;
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  const auto frame = rig.driver().Capture(Seconds(100.4e-6), {});
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_DOUBLE_EQ(frame->exposure.count(), 100e-6);
}

// Frames after a change are thrown away as often as the settings say, and no others.
TEST(GenicamCamera, DiscardsFramesAfterAChange) {
  GenicamSettings settings = DriverSettings();
  settings.discarded_first = 1;
  settings.discarded_on_change = 2;
  GigeRig rig(settings);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  for (const double exposure : {0.001, 0.001, 0.002, 0.002, 0.001}) {
    ASSERT_TRUE(rig.driver().Capture(Seconds(exposure), {}).ok());
  }
  EXPECT_EQ(rig.driver().counters().frames, 5);
  EXPECT_EQ(rig.driver().counters().discarded, 6);
  EXPECT_EQ(rig.device->exposures(), 11);
}

// Example failure is a driver that takes the first camera it finds.
TEST(GenicamCamera, IsFoundByItsSerialNumberOnly) {
  if (!in_own_network) GTEST_SKIP() << "a search would go out on the network";
  GenicamSettings settings = DriverSettings();
  settings.address = "";
  settings.serial = "GP0001";
  GigeRig rig(settings);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  EXPECT_TRUE(rig.driver().Capture(Seconds(0.001), {}).ok());
  settings.serial = "GP0002";
  const auto other = GenicamCamera::Open(settings, *rig.clock);
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.error().code, ErrorCode::kRefused);
  EXPECT_THAT(other.error().message,
              AllOf(HasSubstr("no camera with serial number GP0002"), HasSubstr("GP0001")));
}

struct Refusal {
  const char* name;
  void (*change)(GenicamSettings& settings);
  std::vector<const char*> words;
};
class GenicamRefusals : public testing::TestWithParam<Refusal> {};

TEST_P(GenicamRefusals, SayWhatIsWrong) {
  GenicamSettings settings = DriverSettings();
  GetParam().change(settings);
  const GigeRig rig(settings);
  ASSERT_FALSE(rig.camera.ok());
  EXPECT_EQ(rig.camera.error().code, ErrorCode::kRefused);
  EXPECT_THAT(rig.camera.error().message, HasSubstr("camera: "));
  for (const char* word : GetParam().words) {
    EXPECT_THAT(rig.camera.error().message, HasSubstr(word));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, GenicamRefusals,
    testing::Values(
        Refusal{"Format",
                [](auto& s) { s.pixel_format = "BayerBG16"; },
                {"PixelFormat: wanted BayerBG16", "Mono12p"}},
        Refusal{"UnknownFormat", [](auto& s) { s.pixel_format = "Mono13"; }, {"Mono13"}},
        Refusal{"Width", [](auto& s) { s.width = 2048; }, {"Width: wanted 2048", "4 .. 1024"}},
        Refusal{"WidthStep", [](auto& s) { s.width = 62; }, {"Width: wanted 62", "steps are of 4"}},
        Refusal{"Region", [](auto& s) { s.offset_x = 1000; }, {"1064 px", "SensorWidth"}},
        Refusal{"Gain", [](auto& s) { s.gain_db = 30; }, {"Gain: wanted 30", "0 .. 24"}},
        Refusal{"BlackLevel", [](auto& s) { s.black_level = 300; }, {"BlackLevel: wanted 300"}},
        Refusal{"Line", [](auto& s) { s.trigger_line = "Line7"; }, {"TriggerSource", "Line7"}},
        Refusal{"HostName", [](auto& s) { s.address = "camera.lab"; }, {"no IPv4 address"}}),
    [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace gonio
