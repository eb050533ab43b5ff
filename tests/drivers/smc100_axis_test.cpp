// SPDX-License-Identifier: Apache-2.0
// What goes wrong on an SMC100's line, and what the driver makes of it.
#include "drivers/smc100_axis.h"

#include <gmock/gmock.h>

#include "core/units.h"
#include "drivers/serial_port.h"
#include "sim/pty_server.h"
#include "sim/smc100_emulator.h"

namespace gonio::smc100 {
namespace {

using testing::HasSubstr;

constexpr Seconds kReplyLimit{0.5};  // long: a busy machine may keep the emulator waiting

class Smc100Faults : public testing::Test {
 protected:
  static ControllerAxisSettings Settings() {
    ControllerAxisSettings settings;
    settings.name = "arm";
    settings.limits = {.min_position = -2,
                       .max_position = 3,
                       .max_speed = 0.5,
                       .acceleration = 1,
                       .position_tolerance = 1e-4};
    return settings;
  }
  std::shared_ptr<Line> OpenedLine() const {
    SerialSettings settings;
    settings.port = server_.path();
    settings.flow = SerialSettings::Flow::kXonXoff;
    auto port = SerialPort::Open(settings);
    EXPECT_TRUE(port.ok()) << port.error().message;
    return std::make_shared<Line>(std::move(port).value(), kReplyLimit);
  }
  std::string WhyNot(const ControllerAxisSettings& settings, int address = 1) {
    const auto axis = OpenAxis(line_, address, settings, clock_.get());
    return axis.ok() ? "opened" : axis.error().message;
  }
  std::unique_ptr<Axis> Homed() {
    auto axis = OpenAxis(line_, 1, Settings(), clock_.get());
    EXPECT_TRUE(axis.ok() && (*axis)->Home({}).ok());
    return std::move(axis).value();
  }

  const std::shared_ptr<ManualClock> clock_ = std::make_shared<ManualClock>();
  Smc100Emulator stage_{Smc100Stage{}, clock_};
  PtyServer server_{[this](std::string_view bytes) { return stage_.Receive(bytes); }};
  const std::shared_ptr<Line> line_ = OpenedLine();
};

TEST_F(Smc100Faults, RefusesWhatTheControllerCannotDo) {
  ControllerAxisSettings settings = Settings();
  settings.limits.max_position = 4;
  EXPECT_EQ(WhyNot(settings),
            "arm: limits of -114.592 to 229.183 deg are outside the controller's own, -170 to 175 "
            "deg (SL, SR)");
  settings = Settings();
  settings.limits.max_speed = 2;
  EXPECT_EQ(WhyNot(settings), "arm: " + server_.path() +
                                  ": address 1 refused VA114.591559: parameter missing or out of "
                                  "range");
  EXPECT_EQ(WhyNot(Settings(), 2),
            "arm: " + server_.path() + ": no answer within 0.5 s, address 2, asked SL");
}

TEST_F(Smc100Faults, TakesSilenceForATimeout) {
  const auto axis = Homed();
  stage_.set_silent(true);
  EXPECT_EQ(axis->State().error().code, ErrorCode::kTimeout);
  EXPECT_EQ(axis->Stop().error().code, ErrorCode::kTimeout);
  stage_.set_silent(false);
  EXPECT_TRUE(axis->State().ok());
}

TEST_F(Smc100Faults, AsksAgainAfterAGarbledAnswer) {
  const auto axis = Homed();
  stage_.Garble(1);
  EXPECT_TRUE(axis->State().ok());
  stage_.Garble(2);
  EXPECT_EQ(axis->State().error().code, ErrorCode::kProtocol);
}

// Example failure is a driver that believes that a command was obeyed because nothing came back.
TEST_F(Smc100Faults, NoticesThatACommandWasPassedOver) {
  EXPECT_EQ(line_->Command(1, "PA10").error().code, ErrorCode::kRefused);
  EXPECT_THAT(line_->Command(1, "PA10").error().message,
              HasSubstr("refused PA10: not allowed while not referenced"));
  EXPECT_FALSE(line_->Command(1, "XX").ok());
  // What others did wrong before is not this command's fault.
  stage_.Receive("1XX\r\n");
  EXPECT_TRUE(line_->Command(1, "VA10").ok());
}

TEST_F(Smc100Faults, KnowsThatAResetLosesTheReference) {
  const auto axis = Homed();
  ASSERT_TRUE(axis->StartMove(2).ok());
  clock_->SleepFor(Seconds(0.5));
  stage_.Reset();
  EXPECT_EQ(axis->WaitUntilStill(Seconds(60), {}).error().message,
            "arm: lost its reference on the way");
  EXPECT_EQ(axis->StartMove(1).error().message, "arm: is not homed");
  EXPECT_TRUE(axis->Home({}).ok());
  EXPECT_TRUE(axis->StartMove(1).ok());
}

TEST_F(Smc100Faults, ReportsAFollowingError) {
  const auto axis = Homed();
  ASSERT_TRUE(axis->StartMove(2).ok());
  clock_->SleepFor(Seconds(0.5));
  stage_.Fail(0x20);
  const auto still = axis->WaitUntilStill(Seconds(60), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().code, ErrorCode::kProtocol);
  EXPECT_EQ(still.error().message, "arm: a move ended: following error");
}

TEST_F(Smc100Faults, ReportsThatItWasStoppedShortOfItsTarget) {
  const auto axis = Homed();
  ASSERT_TRUE(axis->StartMove(2).ok());
  clock_->SleepFor(Seconds(0.5));
  stage_.Receive("1ST\r\n");
  EXPECT_THAT(axis->WaitUntilStill(Seconds(60), {}).error().message,
              HasSubstr("instead of 114.592 deg"));
}

}  // namespace
}  // namespace gonio::smc100
