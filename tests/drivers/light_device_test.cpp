// SPDX-License-Identifier: Apache-2.0
#include "drivers/light_device.h"

#include <gmock/gmock.h>

namespace gonio {
namespace {

constexpr const char* kSerial = "driver: dc4100\nport: /dev/ttyUSB3\n";

std::string Complaint(const std::string& text, const std::optional<ColourChannels>& colours) {
  try {
    const ConfigNode node = ConfigNode::Parse(text, "rig.yaml");
    (void)ReadLightDevice(node, colours);
    node.RefuseUnknownKeys();
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "fine";
}

std::string ColourComplaint(const std::string& text) {
  try {
    (void)ReadColourChannels(ConfigNode::Parse(text, "rig.yaml"));
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "fine";
}

TEST(ReadLightDevice, HasOneLedOrOneForEachColour) {
  const auto one = ReadLightDevice(
      ConfigNode::Parse(std::string(kSerial) + "channel: 2\nfull_current_a: 0.7", ""), {});
  ASSERT_EQ(one.leds.size(), 1);
  EXPECT_EQ(one.leds[0].channel, 2);
  EXPECT_EQ(one.leds[0].full_current, 0.7);
  const auto same = ReadLightDevice(
      ConfigNode::Parse(std::string(kSerial) + "full_current_a: 0.7", ""), ColourChannels{3, 0, 1});
  ASSERT_EQ(same.leds.size(), 3);
  EXPECT_EQ(same.leds[0].channel, 3);
  EXPECT_EQ(same.leds[2].channel, 1);
  EXPECT_EQ(same.leds[2].full_current, 0.7);
  const auto own = ReadLightDevice(
      ConfigNode::Parse(std::string(kSerial) + "full_currents_a: [0.7, 0.5, 0.3]", ""),
      ColourChannels{3, 0, 1});
  EXPECT_EQ(own.leds[1].full_current, 0.5);
  EXPECT_EQ(own.leds[2].full_current, 0.3);
}

TEST(ReadLightDevice, RefusesColoursThatItCannotHave) {
  EXPECT_EQ(Complaint("driver: dc2200\nfull_current_a: 1", ColourChannels{0, 1, 2}),
            "rig.yaml:1: driver: dc2200 has one LED, light.colours needs three");
  EXPECT_EQ(
      Complaint(std::string(kSerial) + "channel: 1\nfull_current_a: 1", ColourChannels{0, 1, 2}),
      "rig.yaml:3: channel: light.colours says which channels");
  EXPECT_EQ(Complaint(std::string(kSerial) + "full_current_a: 1", {}),
            "rig.yaml:1: channel: is missing");
}

TEST(ReadColourChannels, WantsEveryColourOnAChannelOfItsOwn) {
  EXPECT_EQ(ReadColourChannels(ConfigNode::Parse("{red: 2, green: 0, blue: 3}", "")),
            (ColourChannels{2, 0, 3}));
  EXPECT_EQ(ColourComplaint("{red: 0, green: 1}"), "rig.yaml:1: blue: is missing");
  EXPECT_EQ(ColourComplaint("{red: 0, green: 1, blue: 1}"),
            "rig.yaml:1: blue: channel 1 is that of green");
  EXPECT_EQ(ColourComplaint("{red: 0, green: 1, blue: 4}"),
            "rig.yaml:1: blue: is 4, must be between 0 and 3");
}

}  // namespace
}  // namespace gonio
