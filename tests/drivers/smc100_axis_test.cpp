// SPDX-License-Identifier: Apache-2.0
// What goes wrong on the lines of SMC100s only, and what the driver makes of it.
#include "drivers/smc100_axis.h"

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <string>

#include "core/units.h"
#include "sim/smc100_emulator.h"
#include "tests/drivers/wire_axis.h"

namespace gonio::smc100 {
namespace {

using testing::HasSubstr;

class Smc100Faults : public testing::Test {
 protected:
  static SerialSettings XonXoff() {
    SerialSettings settings;
    settings.flow = SerialSettings::Flow::kXonXoff;
    return settings;
  }
  std::string WhyNot(const ControllerAxisSettings& settings, int address = 1) {
    const auto axis = OpenAxis(line_, address, settings, clock_.get());
    return axis.ok() ? "opened" : axis.error().message;
  }
  std::unique_ptr<Axis> Homed() {
    auto axis = OpenAxis(line_, 1, ArmSettings(), clock_.get());
    EXPECT_TRUE(axis.ok() && (*axis)->Home({}).ok());
    return std::move(axis).value();
  }

  const std::shared_ptr<ManualClock> clock_ = std::make_shared<ManualClock>();
  Smc100Emulator stage_{Smc100Stage{}, clock_};
  std::atomic<double> seconds_per_answer_ = 0;
  PtyServer server_{[this](std::string_view bytes) {
    std::string answer = stage_.Receive(bytes);
    clock_->SleepFor(Seconds(seconds_per_answer_));
    return answer;
  }};
  const std::shared_ptr<Line> line_ =
      std::make_shared<Line>(OpenedPort(server_, XonXoff()), kWireReplyLimit);
};

TEST_F(Smc100Faults, RefusesWhatTheControllerCannotDo) {
  ControllerAxisSettings settings = ArmSettings();
  settings.limits.max_position = 4;
  EXPECT_EQ(WhyNot(settings),
            "arm: limits of -114.592 to 229.183 deg are outside the controller's own, -170 to 175 "
            "deg (SL, SR)");
  settings = ArmSettings();
  settings.limits.max_speed = 2;
  EXPECT_EQ(WhyNot(settings), "arm: " + server_.path() +
                                  ": address 1 refused VA114.591559: parameter missing or out of "
                                  "range");
  EXPECT_EQ(WhyNot(ArmSettings(), 2),
            "arm: " + server_.path() + ": no answer within 0.5 s, address 2, asked VE");
  EXPECT_EQ(stage_.Shaft(), RadFromDeg(Smc100Stage{}.switched_on_at_deg));
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

// Example failure is an arm that is slower after a power cut, and out of time on its next move.
TEST_F(Smc100Faults, SetsItsSpeedAgainAfterAReset) {
  const auto axis = Homed();
  stage_.Reset();
  EXPECT_EQ(stage_.Receive("1VA?\r\n"), "1VA20\r\n");
  ASSERT_TRUE(axis->Home({}).ok());
  EXPECT_EQ(stage_.Receive("1VA?\r\n"), "1VA28.64789\r\n");
}

// Example failure is a driver that reads its position, and then hears that the move has ended.
TEST_F(Smc100Faults, IsWhereItArrivedOnceItIsStill) {
  const auto axis = Homed();
  ASSERT_TRUE(axis->StartMove(2).ok());
  seconds_per_answer_ = 60;  // it arrives between any two questions
  const Result<AxisState> state = axis->State();
  seconds_per_answer_ = 0;
  ASSERT_TRUE(state.ok()) << state.error().message;
  EXPECT_TRUE(state->moving || std::abs(state->position - 2) < 1e-3) << state->position;
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

}  // namespace
}  // namespace gonio::smc100
