// SPDX-License-Identifier: Apache-2.0
// The light over the real libserialport, with its driver emulated at the other end of a
// pseudo-terminal.
#include "drivers/dc4100_light.h"

#include <gmock/gmock.h>

#include "sim/dc4100_emulator.h"
#include "tests/conformance/light.h"
#include "tests/drivers/wire_axis.h"

namespace gonio {
namespace {

using testing::HasSubstr;

constexpr int kChannel = 2;
constexpr double kFull = 0.7;  // A

// Members are destroyed last to first.
struct Wire {
  Dc4100Emulator driver;
  PtyServer line{[this](std::string_view bytes) { return driver.Receive(bytes); }};

  Result<std::unique_ptr<Light>> Open(double full_current = kFull) {
    return Dc4100Light::Open(
        OpenedPort(line),
        {.name = "lamp", .leds = {{kChannel, full_current}}, .reply_limit = kWireReplyLimit});
  }
};

constexpr Dc4100Led kLeds[] = {{3, 0.7}, {0, 0.5}, {1, 0.25}};  // by colour

struct ColouredWire : Wire {
  Result<std::unique_ptr<Light>> OpenColours(std::vector<Dc4100Led> leds = {kLeds[0], kLeds[1],
                                                                            kLeds[2]}) {
    return Dc4100Light::Open(
        OpenedPort(line),
        {.name = "lamp", .leds = std::move(leds), .reply_limit = kWireReplyLimit});
  }
  double Level(LightColour colour) const {
    const Dc4100Led& led = kLeds[static_cast<std::size_t>(colour)];
    return driver.Current(led.channel) / led.full_current;
  }
};

LightSubject Dc4100Colours() {
  auto wire = std::make_shared<ColouredWire>();
  LightSubject subject;
  auto light = wire->OpenColours();
  EXPECT_TRUE(light.ok()) << light.error().message;
  subject.emitted = [wire] {
    double sum = 0;
    for (const LightColour colour : kLightColours) sum += wire->Level(colour);
    return sum;
  };
  subject.emitted_in = [wire](LightColour colour) { return wire->Level(colour); };
  subject.turn_by_hand = [wire](double level) {
    const Dc4100Led& green = kLeds[1];
    wire->driver.TurnByHand(green.channel, static_cast<int>(1000 * level * green.full_current));
  };
  subject.light_by_hand = [wire](LightColour colour) {
    wire->driver.TurnByHand(kLeds[static_cast<std::size_t>(colour)].channel, 10);
  };
  subject.light = std::move(light).value();
  return subject;
}
INSTANTIATE_TEST_SUITE_P(Dc4100Colours, LightConformance, testing::Values(Dc4100Colours));

// Example failure is a white LED on the fourth channel that somebody left on.
TEST(Dc4100Light, WithColoursSwitchesEveryChannelOff) {
  ColouredWire wire;
  ASSERT_GT(wire.driver.Current(2), 0);
  const auto light = wire.OpenColours();
  ASSERT_TRUE(light.ok()) << light.error().message;
  for (int channel = 0; channel < 4; ++channel) EXPECT_EQ(wire.driver.Current(channel), 0);
  EXPECT_EQ((*light)->identity(),
            "DC4100 M00226347 1.4.0, red channel 3: LED M00200003, 650, constant current, full "
            "0.7 A, limit 0.8 A; green channel 0: LED M00200000, 470, constant current, full 0.5 "
            "A, limit 0.8 A; blue channel 1: LED M00200001, 530, constant current, full 0.25 A, "
            "limit 0.8 A");
}

TEST(Dc4100Light, RefusesMoreThanTheLimitOfAnyColour) {
  ColouredWire wire;
  const auto strong = wire.OpenColours({{3, 0.7}, {0, 0.9}, {1, 0.2}});
  ASSERT_FALSE(strong.ok());
  EXPECT_THAT(strong.error().message, HasSubstr("a full current of 0.9 A is outside 0 .. 0.8 A, "
                                                "the limit of channel 0"));
}

// Example failure is the new LED that is switched on while the old one does not obey.
TEST(Dc4100Light, LightsNoSecondColourIfTheFirstStaysOn) {
  ColouredWire wire;
  auto light = wire.OpenColours();
  ASSERT_TRUE(light.ok());
  ASSERT_TRUE((*light)->Select(LightColour::kRed, {}).ok());
  ASSERT_TRUE((*light)->SetLevel(1).ok());
  wire.driver.set_stuck(kLeds[0].channel);
  const auto selected = (*light)->Select(LightColour::kBlue, {});
  ASSERT_FALSE(selected.ok());
  EXPECT_EQ(selected.error().code, ErrorCode::kRefused);
  EXPECT_THAT(selected.error().message, HasSubstr("o of channel 3 was set to 0 and reads 1"));
  EXPECT_EQ(wire.Level(LightColour::kBlue), 0);
}

LightSubject Dc4100() {
  auto wire = std::make_shared<Wire>();
  LightSubject subject;
  auto light = wire->Open();
  EXPECT_TRUE(light.ok()) << light.error().message;
  subject.emitted = [wire] { return wire->driver.Current(kChannel) / kFull; };
  subject.turn_by_hand = [wire](double level) {
    wire->driver.TurnByHand(kChannel, static_cast<int>(1000 * level * kFull));
  };
  subject.light = std::move(light).value();
  return subject;
}
INSTANTIATE_TEST_SUITE_P(Dc4100, LightConformance, testing::Values(Dc4100));

TEST(Dc4100Light, IsOffOnceOpenedAndLeavesTheOthersAlone) {
  Wire wire;
  const double other = wire.driver.Current(0);
  ASSERT_GT(other, 0);
  const auto light = wire.Open();
  ASSERT_TRUE(light.ok()) << light.error().message;
  EXPECT_EQ(wire.driver.Current(kChannel), 0);
  EXPECT_EQ(*(*light)->Level(), 0);
  EXPECT_EQ(wire.driver.Current(0), other);
  EXPECT_EQ((*light)->identity(),
            "DC4100 M00226347 1.4.0, channel 2: LED M00200002, 590, constant current, full 0.7 A, "
            "limit 0.8 A");
}

TEST(Dc4100Light, RefusesMoreThanTheLimitOfItsChannel) {
  Wire wire;
  for (const double full : {0.9, 0.0, -0.1, std::nan("")}) {
    const auto light = wire.Open(full);
    ASSERT_FALSE(light.ok());
    EXPECT_EQ(light.error().code, ErrorCode::kRefused);
    EXPECT_THAT(light.error().message,
                HasSubstr("A is outside 0 .. 0.8 A, the limit of channel 2"));
  }
}

// Example failure is a lamp that stays dark while everybody believes that it was switched on.
TEST(Dc4100Light, NoticesThatItWasNotObeyed) {
  Wire wire;
  auto light = wire.Open();
  ASSERT_TRUE(light.ok());
  wire.driver.Receive("m 1\r\n");
  const auto set = (*light)->SetLevel(0.5);
  ASSERT_FALSE(set.ok());
  EXPECT_EQ(set.error().code, ErrorCode::kRefused);
  EXPECT_EQ(set.error().message,
            "lamp: " + wire.line.path() + ": refused \"cc 2 350\": \"ERROR 3:Not in this mode\"");
  // What others did wrong before is not this command's fault.
  wire.driver.Receive("m 0\r\nnonsense\r\n");
  EXPECT_TRUE((*light)->SetLevel(0.5).ok());
}

TEST(Dc4100Light, SilenceIsATimeoutAndACableThatIsOutDisconnected) {
  Wire wire;
  auto light = wire.Open();
  ASSERT_TRUE(light.ok());
  wire.line.set_silent(true);
  EXPECT_EQ((*light)->SetLevel(0.5).error().code, ErrorCode::kTimeout);
  EXPECT_EQ((*light)->Level().error().code, ErrorCode::kTimeout);
  wire.line.set_silent(false);
  EXPECT_TRUE((*light)->SetLevel(0.5).ok());
  wire.line.HangUp();
  EXPECT_EQ((*light)->SetLevel(0.5).error().code, ErrorCode::kDisconnected);
  EXPECT_EQ((*light)->Level().error().code, ErrorCode::kDisconnected);
}

}  // namespace
}  // namespace gonio
