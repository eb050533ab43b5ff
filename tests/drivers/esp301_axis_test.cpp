// SPDX-License-Identifier: Apache-2.0
// What goes wrong on the lines of ESP301s only, and what the driver makes of it.
#include "drivers/esp301_axis.h"

#include <gmock/gmock.h>

#include "core/units.h"
#include "sim/esp301_emulator.h"
#include "tests/drivers/wire_axis.h"

namespace gonio::esp301 {
namespace {

using testing::HasSubstr;

// A controller at the end of a line.
struct Bench {
  explicit Bench(const Esp301Stage& settings = {}) : stage(settings, clock) {}

  Result<std::unique_ptr<Axis>> Open(const ControllerAxisSettings& settings = ArmSettings(),
                                     const AxisAddress& address = {}) {
    return OpenAxis(line, address, settings, clock.get());
  }
  std::string WhyNot(const ControllerAxisSettings& settings = ArmSettings(),
                     const AxisAddress& address = {}) {
    const auto axis = Open(settings, address);
    return axis.ok() ? "opened" : axis.error().message;
  }
  std::unique_ptr<Axis> Homed() {
    auto axis = Open();
    EXPECT_TRUE(axis.ok() && (*axis)->Home({}).ok());
    return std::move(axis).value();
  }
  std::unique_ptr<Axis> Moving() {
    auto axis = Homed();
    EXPECT_TRUE(axis->StartMove(2).ok());
    clock->SleepFor(Seconds(0.5));
    return axis;
  }

  const std::shared_ptr<ManualClock> clock = std::make_shared<ManualClock>();
  Esp301Emulator stage;
  Heard heard;
  PtyServer server{[this](std::string_view bytes) {
    heard.Add(bytes);
    return stage.Receive(bytes);
  }};
  const std::shared_ptr<Line> line = std::make_shared<Line>(OpenedPort(server), kWireReplyLimit);
};

TEST(Esp301Axis, SaysWhatItIs) {
  EXPECT_EQ((*Bench().Open())->identity(),
            "Newport ESP301 Version 3.0.1 6/1/99, axis 1: URS100CC, SN4711");
}

TEST(Esp301Axis, RefusesWhatTheControllerCannotDo) {
  Bench bench;
  ControllerAxisSettings settings = ArmSettings();
  settings.limits.max_position = 4;
  EXPECT_EQ(bench.WhyNot(settings),
            "arm: limits of -114.592 to 229.183 deg are outside the controller's own, -170 to 175 "
            "deg (SL, SR)");
  settings = ArmSettings();
  settings.limits.max_speed = 2;
  EXPECT_EQ(bench.WhyNot(settings), "arm: " + bench.server.path() +
                                        ": axis 1 refused VA114.591559: maximum velocity exceeded");
  EXPECT_EQ(bench.WhyNot(ArmSettings(), {.axis = 2, .home_mode = 1}),
            "arm: " + bench.server.path() + ": axis 2 refused ID?: axis number out of range");
  EXPECT_EQ(bench.WhyNot(ArmSettings(), {.axis = 1, .home_mode = 0}),
            "arm: home mode is 0, must be 1 to 6: no other looks for a mark");
  EXPECT_EQ(bench.stage.Shaft(), RadFromDeg(Esp301Stage{}.switched_on_at_deg));
}

// Example failure is a driver that turns a stage by 57 times what was asked for.
TEST(Esp301Axis, RefusesAnotherUnitThanDegrees) {
  Esp301Stage stage;
  stage.unit = 9;
  Bench bench(stage);
  EXPECT_EQ(bench.WhyNot(), "arm: axis 1 counts in rad (SN 9), not in degrees (SN 7)");
}

TEST(Esp301Axis, RefusesAnotherDevice) {
  PtyServer other([](std::string_view) { return "1VE SMC_CC_1.0.1\r\n"; });
  ManualClock clock;
  const auto axis = OpenAxis(std::make_shared<Line>(OpenedPort(other), kWireReplyLimit), {},
                             ArmSettings(), &clock);
  ASSERT_FALSE(axis.ok());
  EXPECT_EQ(axis.error().code, ErrorCode::kRefused);
  EXPECT_EQ(axis.error().message,
            "arm: " + other.path() + ": \"1VE SMC_CC_1.0.1\" is not what was asked for, asked VE?");
}

// Example failure is a driver that believes that a command was obeyed because nothing came back.
TEST(Esp301Line, NoticesThatACommandWasPassedOver) {
  Bench bench;
  EXPECT_EQ(bench.line->Command(1, "PA10").error().code, ErrorCode::kRefused);
  EXPECT_THAT(bench.line->Command(1, "PA10").error().message,
              HasSubstr("axis 1 refused PA10: motor not enabled"));
  ASSERT_TRUE(bench.line->Command(1, "MO").ok());
  EXPECT_THAT(bench.line->Command(1, "PA176").error().message,
              HasSubstr("axis 1 refused PA176: positive software limit"));
  EXPECT_THAT(bench.line->Command(1, "XX").error().message, HasSubstr("command does not exist"));
  EXPECT_EQ(bench.line->FaultAfter(0, 1), "");
}

// Example failure is a driver that reads one error after each command: the tenth of a queue is
// then taken for the refusal of the tenth command from now.
TEST(Esp301Line, EmptiesTheErrorQueueBeforeACommand) {
  Bench bench;
  for (int i = 0; i < 12; ++i) bench.stage.Receive("1XX\r");
  EXPECT_TRUE(bench.line->Command(1, "VA10").ok());
}

TEST(Esp301Line, GivesUpOnAQueueWithoutEnd) {
  PtyServer server([](std::string_view) { return "106\r\n"; });
  const auto read = Line(OpenedPort(server), kWireReplyLimit).ReadErrors();
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(read.error().message, HasSubstr("over 32 errors in its queue"));
}

// Example failure is a driver that gives the errors of axis 2 to whoever reads the queue.
TEST(Esp301Line, KeepsFaultsForTheAxisTheyAreAbout) {
  Bench bench;
  bench.stage.QueueError(203);
  bench.stage.QueueError(106);
  ASSERT_TRUE(bench.line->Command(1, "VA10").ok());
  EXPECT_EQ(bench.line->FaultAfter(0, 1), "");
  EXPECT_EQ(bench.line->FaultAfter(0, 2), "following error");
}

TEST(Esp301Line, PassesOverWhatItDidNotAskFor) {
  Bench bench;
  bench.stage.Blurt("E36, VELOCITY");
  EXPECT_EQ(*bench.line->Value(1, "SR?"), 175);
}

// Bare numbers have no names. Example failure is a driver that takes "moving: 1", which comes late,
// for a position.
TEST(Esp301Line, DoesNotTakeALateAnswerForTheNextOne) {
  std::string late;  // comes before the next answer, whatever is asked
  PtyServer server([&](std::string_view bytes) -> std::string {
    if (bytes == "1MD?\r") {
      late += "1\r\n";
      return {};
    }
    const char* const answer = bytes == "VE?\r"    ? "ESP301 Version 3.0.1 6/1/99\r\n"
                               : bytes == "1TP?\r" ? "-12.5\r\n"
                                                   : "0\r\n";
    return std::exchange(late, {}) + answer;
  });
  Line line(OpenedPort(server), kWireReplyLimit);
  EXPECT_EQ(line.Flag(1, "MD?").error().code, ErrorCode::kTimeout);
  const auto position = line.Value(1, "TP?");
  ASSERT_TRUE(position.ok()) << position.error().message;
  EXPECT_EQ(*position, -12.5);
}

TEST(Esp301Line, RefusesAnswersOfAnotherForm) {
  PtyServer server([](std::string_view bytes) {
    return bytes == "VE?\r" ? "ESP301 Version 3.0.1\r\n" : "12.5\r\n";
  });
  Line line(OpenedPort(server), kWireReplyLimit);
  EXPECT_EQ(line.Flag(1, "MD?").error().message,
            server.path() + ": \"12.5\" does not answer MD?, asked 1MD?");
  EXPECT_EQ(line.Unit(1).error().code, ErrorCode::kProtocol);
  EXPECT_EQ(line.Command(1, "MO").error().code, ErrorCode::kProtocol);
}

// There is no checksum: what is said of garbled answers in wire_axes_test.cpp holds where they no
// longer have their form.
TEST(Esp301Line, CannotNoticeADigitThatTurnedIntoAnother) {
  Bench bench;
  bench.server.Garble(1);
  EXPECT_EQ(*bench.line->Value(1, "SR?"), 155) << "instead of 175";
}

// Example failure is a driver that asks for errors first, and stops nothing if no answer comes.
TEST(Esp301Axis, SendsAStopBeforeItAsksAnything) {
  Bench bench;
  const auto axis = bench.Moving();
  bench.server.set_silent(true);
  EXPECT_EQ(axis->Stop().error().code, ErrorCode::kTimeout);
  const double shaft = bench.stage.Shaft();
  bench.clock->SleepFor(Seconds(1));
  EXPECT_EQ(bench.stage.Shaft(), shaft);
}

TEST(Esp301Axis, ReportsAFollowingErrorAndLosesItsReference) {
  Bench bench;
  const auto axis = bench.Moving();
  bench.stage.Fail(3);
  const auto still = axis->WaitUntilStill(Seconds(60), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().code, ErrorCode::kProtocol);
  EXPECT_EQ(still.error().message, "arm: a move ended: following error");
  EXPECT_EQ(axis->StartMove(1).error().message, "arm: is not homed since: following error");
  EXPECT_TRUE(axis->Home({}).ok());
  EXPECT_TRUE(axis->StartMove(1).ok());
}

// Example failure is a driver that loses the fault when a stop reads the queue, in another thread.
TEST(Esp301Axis, KeepsAFaultThatAStopHasRead) {
  Bench bench;
  const auto axis = bench.Moving();
  bench.stage.Fail(4);
  ASSERT_TRUE(axis->Stop().ok());
  EXPECT_EQ(axis->WaitUntilStill(Seconds(60), {}).error().message,
            "arm: a move ended: positive hardware limit");
}

// Example failure is a driver that calls itself homed once the motor stands.
TEST(Esp301Axis, IsNotHomedByASearchThatSomebodyEnded) {
  const auto clock = std::make_shared<ManualClock>();
  Esp301Emulator stage({}, clock);
  int looks = -1;  // since the search began; -1: it has not
  PtyServer server([&](std::string_view bytes) {
    // With what follows it, if that was sent before this was read.
    if (bytes.find("OR1\r") != std::string_view::npos) looks = 0;
    if (bytes == "1MD?\r" && looks >= 0 && ++looks == 3) stage.Receive("1ST\r");
    return stage.Receive(bytes);
  });
  const auto line = std::make_shared<Line>(OpenedPort(server), kWireReplyLimit);
  const auto axis = std::move(OpenAxis(line, {}, ArmSettings(), clock.get())).value();
  EXPECT_EQ(axis->Home({}).error().message, "arm: homing ended: homing aborted");
  EXPECT_FALSE(axis->State()->homed);
  EXPECT_EQ(axis->StartMove(1).error().message, "arm: is not homed since: homing aborted");
}

// Example failure is a driver that calls itself homed because an axis that has not begun stands.
TEST(Esp301Axis, IsNotHomedByASearchThatNeverBegan) {
  const auto clock = std::make_shared<ManualClock>();
  Esp301Emulator stage({}, clock);
  PtyServer server([&](std::string_view bytes) {
    std::string heard(bytes);
    if (const auto at = heard.find("1OR1\r"); at != heard.npos) heard.erase(at, 5);
    return stage.Receive(heard);  // obeyed, it says
  });
  const auto line = std::make_shared<Line>(OpenedPort(server), kWireReplyLimit);
  ControllerAxisSettings settings = ArmSettings();
  settings.home_limit = Seconds(0.2);
  const auto axis = std::move(OpenAxis(line, {}, settings, clock.get())).value();
  EXPECT_EQ(axis->Home({}).error().message, "arm: homing took over 0.2 s");
  EXPECT_FALSE(axis->State()->homed);
}

// The controller has no word for it.
TEST(Esp301Axis, IsNotHomedByAnEarlierOpening) {
  Bench bench;
  bench.Homed();
  const auto again = std::move(bench.Open()).value();
  EXPECT_FALSE(again->State()->homed);
  EXPECT_EQ(again->StartMove(1).error().message, "arm: is not homed");
}

// Example failure is a driver that asks for power only: somebody has given it back meanwhile.
TEST(Esp301Axis, NoticesAResetByTheSpeedItHasForgotten) {
  Bench bench;
  const auto axis = bench.Homed();
  bench.stage.Reset();
  bench.stage.Receive("1MO\r");
  EXPECT_FALSE(axis->State()->homed);
  EXPECT_EQ(axis->StartMove(1).error().message, "arm: is not homed");
  bench.heard.Clear();
  ASSERT_TRUE(axis->Home({}).ok());
  EXPECT_THAT(bench.heard.Text(), HasSubstr("1VA28.647890\r"));
  EXPECT_THAT(bench.heard.Text(), HasSubstr("1AC57.295780\r"));
  EXPECT_THAT(bench.heard.Text(), HasSubstr("1AG57.295780\r"));
}

TEST(Esp301Axis, AnEmergencyStopIsAStateUntilItIsHomedAgain) {
  Bench bench;
  const auto axis = bench.Moving();
  bench.stage.Receive("AB\r");  // as the button at its input does
  const auto still = axis->WaitUntilStill(Seconds(60), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().code, ErrorCode::kEmergencyStop);
  EXPECT_EQ(axis->StartMove(1).error().message, "arm: an emergency stop is pressed");
  EXPECT_TRUE(axis->Home({}).ok());
  EXPECT_TRUE(axis->StartMove(1).ok());
}

TEST(Esp301Axis, StopsHardInAnEmergencyAndIsNotHomedAfterIt) {
  Bench bench;
  const auto axis = bench.Moving();
  bench.heard.Clear();
  ASSERT_TRUE(axis->EmergencyStop().ok());
  EXPECT_EQ(bench.heard.Text().substr(0, 3), "AB\r");
  EXPECT_EQ(axis->StartMove(1).error().message, "arm: is not homed since: aborted");
}

}  // namespace
}  // namespace gonio::esp301
