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
    return Dc4100Light::Open(OpenedPort(line), {.name = "lamp",
                                                .channel = kChannel,
                                                .full_current = full_current,
                                                .reply_limit = kWireReplyLimit});
  }
};

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
