// SPDX-License-Identifier: Apache-2.0
// What goes wrong on boards with Grbl only, and what the driver makes of it.
#include <gmock/gmock.h>

#include "core/units.h"
#include "tests/drivers/grbl_board.h"

namespace gonio::grbl {
namespace {

using testing::HasSubstr;

using GrblFaults = GrblTest;

TEST_F(GrblFaults, RefusesWhatTheControllerCannotDo) {
  SwitchOn();
  ControllerAxisSettings settings = Settings();
  settings.limits.max_position = 2.7;
  EXPECT_EQ(WhyNot(settings),
            "arm: limits of -114.592 to 154.699 deg are outside the controller's own, -121.031 to "
            "148.969 deg ($130)");
  settings = Settings();
  settings.limits.max_speed = 1;
  EXPECT_EQ(WhyNot(settings),
            "arm: a speed of 57.2958 deg/s is above its 40 deg/s ($110 is 2400 "
            "deg/min)");
  settings = Settings();
  settings.limits.position_tolerance = 1e-5;
  EXPECT_EQ(WhyNot(settings),
            "arm: a tolerance of 0.000573 deg is finer than its steps, 0.00225 deg");
  EXPECT_EQ(WhyNot(Settings(), 'A'), "arm: no axis A, of XYZ");
  EXPECT_DOUBLE_EQ(board_->Shaft(), RadFromDeg(-80));
  EXPECT_EQ(board_->Heard("$J"), 0);
}

TEST_F(GrblFaults, RefusesSettingsThatPositionsCannotBeReliedOnWith) {
  const auto with = [](std::map<int, double> settings) {
    GrblBoard board;
    board.settings = std::move(settings);
    return board;
  };
  EXPECT_EQ(WhyNotBoard(with({{22, 0}, {20, 0}})),
            "arm: homing is switched off: set $22=1, it is 0");
  EXPECT_EQ(WhyNotBoard(with({{20, 0}})), "arm: soft limits are switched off: set $20=1, it is 0");
  EXPECT_EQ(WhyNotBoard(with({{1, 25}})),
            "arm: its motors lose their power, and steps, between moves: set $1=255, it is 25");
  EXPECT_EQ(WhyNotBoard(with({{13, 1}})), "arm: it reports in inches: set $13=0, it is 1");
}

TEST_F(GrblFaults, RefusesAnotherVersion) {
  GrblBoard old;
  old.version = "0.9j.20160316:";
  SwitchOn(old);
  EXPECT_EQ(OpenMachine().error().message,
            line_->path() + ": version \"0.9j.20160316:\" is not Grbl 1.1");
}

TEST_F(GrblFaults, RefusesAnotherDevice) {
  SwitchOn();
  PtyServer stage([](std::string_view) { return "@01 0 OK IDLE -- 0\r\n"; });
  const auto machine = Machine::Open(OpenedPort(stage), clock_.get(),
                                     {.reply = kWireReplyLimit, .boot = Seconds(0.01)});
  ASSERT_FALSE(machine.ok());
  EXPECT_EQ(machine.error().message, stage.path() +
                                         ": \"@01 0 OK IDLE -- 0\" is not a line of Grbl's, asked "
                                         "?");
}

TEST_F(GrblFaults, SaysWhatItIsAndKeepsItsAcceleration) {
  SwitchOn();
  const auto axis = Opened('Y');
  EXPECT_EQ(axis->identity(), "Grbl 1.1h.20190825, \"left arm\", options \"V,15,128\", axis Y");
  EXPECT_EQ(board_->Heard("$121=57.296"), 1);
  EXPECT_NEAR(*machine_->Setting(121), 57.296, 1e-3);
  // Written only if it differs: its memory wears.
  const auto again = Opened('Y');
  EXPECT_EQ(board_->Heard("$121="), 1);
}

// Boards without the reset that opening causes say nothing until they are asked.
TEST_F(GrblFaults, OpensOneThatDoesNotReset) {
  SwitchOn();
  const auto machine = Machine::Open(OpenedPort(*line_), clock_.get(),
                                     {.reply = kWireReplyLimit, .boot = Seconds(0.01)});
  ASSERT_TRUE(machine.ok()) << machine.error().message;
  EXPECT_FALSE((*machine)->Status(0)->homed);
}

// Example failure is a driver that believes the state "Idle" of a board that was unlocked by hand.
TEST_F(GrblFaults, IsNotHomedBecauseItIsIdle) {
  SwitchOn();
  const auto axis = Opened('X');
  board_->Receive("$X\n");
  EXPECT_FALSE(axis->State()->homed);
  EXPECT_EQ(axis->StartMove(1).error().message, "arm: is not homed");
  EXPECT_TRUE(axis->Home({}).ok());
  EXPECT_TRUE(axis->State()->homed);
  EXPECT_EQ(board_->Heard("$X"), 1);  // ours
}

TEST_F(GrblFaults, ReadsWorkPositionsWithTheirOffset) {
  GrblBoard board;
  board.settings = {{10, 0}};
  SwitchOn(board);
  const auto axis = Opened('X');
  ASSERT_TRUE(axis->Home({}).ok());
  ASSERT_TRUE(axis->StartMove(1).ok());
  EXPECT_EQ(WhyNotThere(*axis), "there");
  EXPECT_NEAR(Angle(0), 1, 1e-4);
}

TEST_F(GrblFaults, HomingTakesLongerThanAnAnswer) {
  GrblBoard board;
  board.settings = {{25, 60}};  // deg/min
  SwitchOn(board);
  const auto axis = Opened('X');
  ASSERT_TRUE(machine_->StartHoming(0).ok());
  for (int i = 0; i < 30; ++i) {
    clock_->SleepFor(Seconds(0.1));
    const auto state = axis->State();
    ASSERT_TRUE(state.ok()) << state.error().message;
    EXPECT_TRUE(state->moving);
    EXPECT_FALSE(state->homed);
  }
  EXPECT_EQ(axis->StartMove(1).error().message, "arm: is not homed");
}

TEST_F(GrblFaults, HomingIsBounded) {
  GrblBoard board;
  board.settings = {{25, 60}};
  SwitchOn(board);
  ControllerAxisSettings settings = Settings();
  settings.home_limit = Seconds(1);
  auto axis = Open('X', settings);
  ASSERT_TRUE(axis.ok());
  EXPECT_EQ((*axis)->Home({}).error().message, "arm: homing took over 1 s");
  EXPECT_FALSE((*axis)->State()->moving);
  EXPECT_FALSE((*axis)->State()->homed);
}

TEST_F(GrblFaults, SaysWhyHomingFailed) {
  SwitchOn();
  const auto axis = Opened('X');
  board_->LoseSwitches();
  const auto homed = axis->Home({});
  ASSERT_FALSE(homed.ok());
  EXPECT_EQ(homed.error().message,
            "arm: homing ended: alarm 9, homing did not find the limit switch");
  EXPECT_FALSE(axis->State()->homed);
}

// It answers nothing then but a reset.
TEST_F(GrblFaults, ReportsAHardLimit) {
  const auto axis = Homed();
  ASSERT_TRUE(axis->StartMove(-1).ok());
  clock_->SleepFor(Seconds(0.5));
  board_->HitLimitSwitch();
  EXPECT_EQ(WhyNotThere(*axis), "arm: a move ended: alarm 1, hard limit: a switch stopped it");
  EXPECT_EQ(axis->StartMove(1).error().message,
            "arm: is not homed since: alarm 1, hard limit: a switch stopped it");
  EXPECT_TRUE(axis->State().ok());
  EXPECT_TRUE(axis->Home({}).ok());
  EXPECT_TRUE(axis->StartMove(1).ok());
  EXPECT_EQ(board_->Heard("$X"), 0);
}

TEST_F(GrblFaults, AResetButtonPressedOnTheWayCostsThePosition) {
  const auto axis = Homed();
  ASSERT_TRUE(axis->StartMove(-1).ok());
  clock_->SleepFor(Seconds(0.5));
  board_->Press('\x18');
  EXPECT_EQ(WhyNotThere(*axis), "arm: a move ended: alarm 3, reset while it moved");
  EXPECT_EQ(axis->StartMove(1).error().message,
            "arm: is not homed since: alarm 3, reset while it moved");
}

// It is idle after that, and not locked.
TEST_F(GrblFaults, AResetButtonPressedAtRestCostsThePosition) {
  const auto axis = Homed();
  board_->Press('\x18');
  EXPECT_FALSE(axis->State()->homed);
  EXPECT_EQ(axis->StartMove(1).error().message, "arm: is not homed");
}

TEST_F(GrblFaults, AnEmergencyStopCostsThePosition) {
  const auto axis = Homed();
  ASSERT_TRUE(axis->StartMove(-1).ok());
  clock_->SleepFor(Seconds(0.5));
  ASSERT_TRUE(axis->EmergencyStop().ok());
  EXPECT_FALSE(axis->State()->homed);
  EXPECT_EQ(axis->StartMove(1).error().message, "arm: is not homed");
  EXPECT_TRUE(axis->Home({}).ok());
  // As does one at rest: it may have been turned by hand since.
  ASSERT_TRUE(axis->EmergencyStop().ok());
  EXPECT_FALSE(axis->State()->homed);
}

TEST_F(GrblFaults, AHeldMachineIsNotSentOnItsWay) {
  const auto axis = Homed();
  board_->Press('!');
  EXPECT_EQ(axis->StartMove(1).error().message, "arm: is not homed since: it is in a feed hold");
  EXPECT_TRUE(axis->Home({}).ok());
  EXPECT_TRUE(axis->StartMove(1).ok());
}

// Answers have no numbers. Example failure is a driver that takes the late "ok" of one jog for that
// of the next, which was refused.
TEST_F(GrblFaults, DoesNotTakeALateAnswerForTheNextOne) {
  const auto axis = Homed();
  board_->HoldBack(1);
  const auto started = axis->StartMove(1);
  ASSERT_FALSE(started.ok());
  EXPECT_EQ(started.error().code, ErrorCode::kTimeout);
  EXPECT_THAT(started.error().message,
              HasSubstr("no answer within 0.5 s, told $J=G21G53X-91.6732F"));
  EXPECT_EQ(board_->Heard("$J"), 1);  // not sent again
  const auto beyond = machine_->StartMove(0, 5, 10);
  ASSERT_FALSE(beyond.ok());
  EXPECT_THAT(beyond.error().message,
              HasSubstr("refused $J=G21G53X5.0000F600.000: error 15, beyond the travel"));
  EXPECT_TRUE(axis->State()->homed);
}

// Nobody knows then whether it was heard.
TEST_F(GrblFaults, AGarbledOkIsAnErrorAndNothingIsSentAgain) {
  const auto axis = Homed();
  garble_jogs_ = true;
  EXPECT_EQ(axis->StartMove(1).error().code, ErrorCode::kProtocol);
  EXPECT_EQ(board_->Heard("$J"), 1);
  ASSERT_TRUE(axis->State().ok());  // it has heard that it should stop
  clock_->SleepFor(Seconds(0.2));
  EXPECT_FALSE(axis->State()->moving);
  garble_jogs_ = false;
  EXPECT_TRUE(axis->StartMove(1).ok());
}

TEST_F(GrblFaults, GivesUpOnADeviceThatOnlyTalksToItself) {
  SwitchOn();
  PtyServer flood([](std::string_view) { return std::string(10000, '<'); });
  const auto machine = Machine::Open(OpenedPort(flood), clock_.get(),
                                     {.reply = kWireReplyLimit, .boot = Seconds(0.01)});
  ASSERT_FALSE(machine.ok());
  EXPECT_THAT(machine.error().message, HasSubstr("4096 bytes and no end of line"));
}

}  // namespace
}  // namespace gonio::grbl
