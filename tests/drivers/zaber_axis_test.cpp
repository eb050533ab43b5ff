// SPDX-License-Identifier: Apache-2.0
// What goes wrong on a Zaber chain, and what the driver makes of it.
#include "drivers/zaber_axis.h"

#include <gmock/gmock.h>

#include "core/units.h"
#include "drivers/serial_port.h"
#include "sim/pty_server.h"
#include "sim/zaber_emulator.h"

namespace gonio::zaber {
namespace {

using testing::HasSubstr;

constexpr Seconds kReplyLimit{0.5};  // long: a busy machine may keep the emulator waiting

std::shared_ptr<Chain> ChainTo(const PtyServer& line) {
  SerialSettings settings;
  settings.port = line.path();
  auto port = SerialPort::Open(settings);
  EXPECT_TRUE(port.ok()) << port.error().message;
  return std::make_shared<Chain>(std::move(port).value(), kReplyLimit);
}

ControllerAxisSettings Settings() {
  ControllerAxisSettings settings;
  settings.name = "arm";
  settings.limits = {.min_position = -2,
                     .max_position = 3,
                     .max_speed = 0.5,
                     .acceleration = 1,
                     .position_tolerance = 1e-4};
  return settings;
}

class ZaberFaults : public testing::Test {
 protected:
  Result<std::unique_ptr<Axis>> Open(const ControllerAxisSettings& settings = Settings(),
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
  ControllerAxisSettings settings = Settings();
  settings.limits.max_position = 7;
  EXPECT_EQ(
      WhyNot(settings),
      "arm: limits of -114.592 to 401.07 deg are outside the controller's own, -360 to 360 deg "
      "(limit.min, limit.max)");
  settings = Settings();
  settings.limits.max_speed = 100;
  EXPECT_THAT(WhyNot(settings), HasSubstr("device 1 axis 1 rejected \"set maxspeed 10013163\""));
  settings.limits.max_speed = 1e-9;
  EXPECT_EQ(WhyNot(settings), "arm: maxspeed would be 0: too slow for it");
  EXPECT_EQ(WhyNot(Settings(), {.device = 2, .axis = 1}),
            "arm: " + line_.path() +
                ": no answer within 0.5 s, device 2 axis 1, asked \"get "
                "limit.cycle.dist\"");
  EXPECT_EQ(stage_.Shaft(), ZaberStage{}.switched_on_at / ZaberStage{}.steps_per_turn * 2 * kPi);
}

TEST_F(ZaberFaults, TakesSilenceForATimeout) {
  const auto axis = Homed();
  stage_.set_silent(true);
  EXPECT_EQ(axis->State().error().code, ErrorCode::kTimeout);
  EXPECT_EQ(axis->StartMove(1).error().code, ErrorCode::kTimeout);
  EXPECT_EQ(axis->WaitUntilStill(Seconds(1), {}).error().code, ErrorCode::kTimeout);
  EXPECT_EQ(axis->Stop().error().code, ErrorCode::kTimeout);
  stage_.set_silent(false);
  EXPECT_TRUE(axis->State().ok());
}

TEST_F(ZaberFaults, AsksAgainAfterAGarbledReplyButDoesNotCommandTwice) {
  const auto axis = Homed();
  stage_.Garble(1);
  EXPECT_TRUE(axis->State().ok());
  stage_.Garble(2);
  EXPECT_EQ(axis->State().error().code, ErrorCode::kProtocol);
  stage_.Garble(1);
  const auto stopped = axis->Stop();
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(stopped.error().message, HasSubstr("asked \"stop\""));
}

TEST_F(ZaberFaults, KnowsThatAResetLosesTheReference) {
  const auto axis = Homed();
  ASSERT_TRUE(axis->StartMove(2).ok());
  clock_->SleepFor(Seconds(0.5));
  stage_.Reset();
  const auto still = axis->WaitUntilStill(Seconds(60), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().message, "arm: lost its reference on the way");
  EXPECT_FALSE(axis->State()->homed);
  EXPECT_EQ(axis->StartMove(1).error().message, "arm: is not homed");
  EXPECT_TRUE(axis->Home({}).ok());
  EXPECT_TRUE(axis->StartMove(1).ok());
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
  EXPECT_TRUE(axis->State()->homed);  // seen behind the graver flag
}

TEST_F(ZaberFaults, ReportsThatItWasStoppedShortOfItsTarget) {
  const auto axis = Homed();
  ASSERT_TRUE(axis->StartMove(2).ok());
  clock_->SleepFor(Seconds(0.5));
  stage_.Receive("/1 1 stop\n");  // somebody turned the knob
  const auto still = axis->WaitUntilStill(Seconds(60), {});
  ASSERT_FALSE(still.ok());
  EXPECT_THAT(still.error().message, HasSubstr("instead of 114.592 deg"));
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
