// SPDX-License-Identifier: Apache-2.0
// What goes wrong on Zaber chains only, and what the driver makes of it.
#include "drivers/zaber_axis.h"

#include <gmock/gmock.h>

#include "core/units.h"
#include "sim/zaber_emulator.h"
#include "tests/drivers/wire_axis.h"

namespace gonio::zaber {
namespace {

using testing::HasSubstr;

std::shared_ptr<Chain> ChainTo(const PtyServer& line) {
  return std::make_shared<Chain>(OpenedPort(line), kWireReplyLimit);
}

class ZaberFaults : public testing::Test {
 protected:
  Result<std::unique_ptr<Axis>> Open(const ControllerAxisSettings& settings = ArmSettings(),
                                     const Address& address = {}) {
    return OpenAxis(chain_, address, settings, clock_.get());
  }
  std::string WhyNot(const ControllerAxisSettings& settings, const Address& address = {}) {
    const auto axis = Open(settings, address);
    return axis.ok() ? "opened" : axis.error().message;
  }
  std::unique_ptr<Axis> Homed() {
    auto axis = Open();
    EXPECT_TRUE(axis.ok() && (*axis)->Home({}).ok());
    return std::move(axis).value();
  }

  const std::shared_ptr<ManualClock> clock_ = std::make_shared<ManualClock>();
  ZaberEmulator stage_{ZaberStage{}, clock_};
  PtyServer line_{[this](std::string_view bytes) { return stage_.Receive(bytes); }};
  const std::shared_ptr<Chain> chain_ = ChainTo(line_);
};

TEST_F(ZaberFaults, RefusesWhatTheControllerCannotDo) {
  ControllerAxisSettings settings = ArmSettings();
  settings.limits.max_position = 7;
  EXPECT_EQ(
      WhyNot(settings),
      "arm: limits of -114.592 to 401.07 deg are outside the controller's own, -360 to 360 deg "
      "(limit.min, limit.max)");
  settings = ArmSettings();
  settings.limits.max_speed = 100;
  EXPECT_THAT(WhyNot(settings), HasSubstr("device 1 axis 1 rejected \"set maxspeed 10013163\""));
  settings.limits.max_speed = 1e-9;
  EXPECT_EQ(WhyNot(settings), "arm: maxspeed would be 0: too slow for it");
  EXPECT_EQ(
      WhyNot(ArmSettings(), {.device = 2, .axis = 1}),
      "arm: " + line_.path() + ": no answer within 0.5 s, device 2 axis 0, asked \"get deviceid\"");
  EXPECT_EQ(stage_.Shaft(), ZaberStage{}.switched_on_at / ZaberStage{}.steps_per_turn * 2 * kPi);
}

TEST_F(ZaberFaults, ReportsAStall) {
  const auto axis = Homed();
  ASSERT_TRUE(axis->StartMove(2).ok());
  clock_->SleepFor(Seconds(0.5));
  stage_.Stall();
  const auto still = axis->WaitUntilStill(Seconds(60), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().code, ErrorCode::kProtocol);
  EXPECT_EQ(still.error().message, "arm: a move ended: fault FS");
}

TEST_F(ZaberFaults, AnEmergencyStopIsAStateOfItsOwn) {
  const auto axis = Homed();
  ASSERT_TRUE(axis->StartMove(2).ok());
  clock_->SleepFor(Seconds(0.5));
  stage_.PressEmergencyStop();
  const auto still = axis->WaitUntilStill(Seconds(60), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().code, ErrorCode::kEmergencyStop);
  EXPECT_EQ(still.error().message, "arm: an emergency stop is pressed");
  EXPECT_EQ(axis->State().error().code, ErrorCode::kEmergencyStop);
  EXPECT_EQ(axis->StartMove(1).error().code, ErrorCode::kEmergencyStop);
  EXPECT_EQ(axis->Home({}).error().code, ErrorCode::kEmergencyStop);
  stage_.ReleaseEmergencyStop();
  EXPECT_EQ(axis->StartMove(1).error().code, ErrorCode::kRefused);  // is not homed
  EXPECT_TRUE(axis->Home({}).ok());
  EXPECT_TRUE(axis->StartMove(1).ok());
}

// Example failure is a driver that takes the next line for the answer.
TEST(ZaberChain, DoesNotTakeALateReplyForTheNextOne) {
  int asked = 0;
  PtyServer line([&](std::string_view) -> std::string {
    switch (++asked) {
      case 1:
        return {};
      default:  // of number 1, at last, something unasked, and of number 2
        return "@01 1 1 OK IDLE -- 111\r\n!01 1 IDLE FS\r\n#01 0 2 hello\r\n@01 2 2 OK IDLE -- "
               "0\r\n"
               "@01 1 2 OK IDLE -- 222\r\n";
    }
  });
  const auto chain = ChainTo(line);
  EXPECT_EQ(chain->Command(1, 1, "get pos").error().code, ErrorCode::kTimeout);
  const auto second = chain->Command(1, 1, "get pos");
  ASSERT_TRUE(second.ok()) << second.error().message;
  EXPECT_EQ(second->data, "222");
}

TEST(ZaberChain, GivesUpOnADeviceThatOnlyTalksToItself) {
  PtyServer line([](std::string_view) { return std::string(10000, '#'); });
  const auto reply = ChainTo(line)->Command(1, 1, "get pos");
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(reply.error().message, HasSubstr("4096 bytes and no end of line"));
}

}  // namespace
}  // namespace gonio::zaber
