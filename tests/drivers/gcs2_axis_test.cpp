// SPDX-License-Identifier: Apache-2.0
// What goes wrong with PI's controllers only, and what the driver makes of it.
#include "drivers/gcs2_axis.h"

#include <gmock/gmock.h>

#include "core/units.h"
#include "sim/gcs2_emulator.h"
#include "tests/drivers/wire_axis.h"

namespace gonio::gcs2 {
namespace {

using testing::HasSubstr;

constexpr char kIdentity[] = "(c)2015 Physik Instrumente (PI) GmbH & Co. KG, C-863.11, 1, 1\n";

// A controller at the end of a line.
struct Bench {
  explicit Bench(const Gcs2Stage& settings = {}) : stage(settings, clock) {}

  Result<std::unique_ptr<Axis>> Open(const ControllerAxisSettings& settings = ArmSettings(),
                                     const AxisAddress& address = {}) {
    return OpenAxis(line, address, settings, clock.get());
  }
  std::string WhyNot(const ControllerAxisSettings& settings = ArmSettings(),
                     const AxisAddress& address = {}) {
    const auto axis = Open(settings, address);
    return axis.ok() ? "opened" : axis.error().message;
  }
  std::unique_ptr<Axis> Homed(const AxisAddress& address = {}) {
    auto axis = Open(ArmSettings(), address);
    EXPECT_TRUE(axis.ok() && (*axis)->Home({}).ok());
    return std::move(axis).value();
  }
  std::unique_ptr<Axis> Moving() {
    auto axis = Homed();
    EXPECT_TRUE(axis->StartMove(2).ok());
    clock->SleepFor(Seconds(0.5));
    return axis;
  }
  bool Turns() {
    const double before = stage.Shaft();
    clock->SleepFor(Seconds(1));
    return stage.Shaft() != before;
  }

  const std::shared_ptr<ManualClock> clock = std::make_shared<ManualClock>();
  Gcs2Emulator stage;
  Heard heard;
  PtyServer server{[this](std::string_view bytes) {
    heard.Add(bytes);
    return stage.Receive(bytes);
  }};
  const std::shared_ptr<Line> line = std::make_shared<Line>(OpenedPort(server), kWireReplyLimit);
};

TEST(Gcs2Axis, SaysWhatItIs) {
  EXPECT_EQ((*Bench().Open())->identity(),
            "(c)2015 Physik Instrumente (PI) GmbH & Co. KG, C-863.11, 0018550027, 1.2.1.0, axis 1");
  Gcs2Stage stage;
  stage.unit.clear();
  EXPECT_THAT((*Bench(stage).Open())->identity(), HasSubstr("axis 1, does not tell its unit"));
}

TEST(Gcs2Axis, RefusesWhatTheControllerCannotDo) {
  Bench bench;
  ControllerAxisSettings settings = ArmSettings();
  settings.limits.max_position = 4;
  EXPECT_EQ(bench.WhyNot(settings),
            "arm: limits of -114.592 to 229.183 deg are outside the controller's own, -170 to 175 "
            "deg (TMN?, TMX?)");
  settings = ArmSettings();
  settings.limits.max_speed = 2;
  EXPECT_EQ(bench.WhyNot(settings),
            "arm: " + bench.server.path() + ": refused VEL 1 114.591559: velocity out of limits");
  EXPECT_EQ(bench.WhyNot(ArmSettings(), {.controller = 0, .axis = "3"}),
            "arm: the controller has no axis 3, but \"1\"");
  EXPECT_EQ(bench.stage.Shaft(), RadFromDeg(Gcs2Stage{}.switched_on_at_deg));
}

// Example failure is a driver that takes the millimetres of a linear stage for degrees.
TEST(Gcs2Axis, RefusesAnotherUnitThanDegrees) {
  Gcs2Stage stage;
  stage.unit = "MM";
  EXPECT_EQ(Bench(stage).WhyNot(), "arm: axis 1 counts in \"MM\", not in degrees");
}

TEST(Gcs2Axis, RefusesAnotherDevice) {
  PtyServer other([](std::string_view) { return "THORLABS,PM100D,P0001,2.4.0\n"; });
  ManualClock clock;
  const auto axis = OpenAxis(std::make_shared<Line>(OpenedPort(other), kWireReplyLimit), {},
                             ArmSettings(), &clock);
  ASSERT_FALSE(axis.ok());
  EXPECT_EQ(axis.error().code, ErrorCode::kRefused);
  EXPECT_EQ(axis.error().message,
            "arm: " + other.path() +
                ": \"THORLABS,PM100D,P0001,2.4.0\" is not what was asked for, asked *IDN?");
}

// Example failure is a driver that looks at the bit of another axis, or at all of them.
TEST(Gcs2Axis, KnowsItsBitAmongThoseOfOtherAxes) {
  Gcs2Stage stage;
  stage.axes = {"A", "B", "C"};
  stage.axis = "B";
  Bench bench(stage);
  const auto axis = bench.Homed({.controller = 0, .axis = "B"});
  EXPECT_FALSE(axis->State()->moving);
  ASSERT_TRUE(axis->StartMove(1).ok());
  EXPECT_TRUE(axis->State()->moving);
  EXPECT_TRUE(axis->WaitUntilStill(Seconds(60), {}).ok());
}

TEST(Gcs2Axis, SpeaksToOneControllerOfAChain) {
  Gcs2Stage stage;
  stage.address = 2;
  stage.axes = {"1", "2"};
  Bench bench(stage);
  const auto axis = bench.Homed({.controller = 2, .axis = "1"});
  ASSERT_TRUE(axis->StartMove(1).ok());
  EXPECT_TRUE(axis->Stop().ok());
  EXPECT_FALSE(bench.Turns());
  EXPECT_THAT(bench.line->Command(2, "XXX 1").error().message,
              HasSubstr("controller 2 refused XXX 1: unknown command"));
  EXPECT_EQ(bench.line->Identity(1).error().code, ErrorCode::kTimeout);
}

TEST(Gcs2Axis, EnablesMotorsThatMustBeEnabled) {
  Gcs2Stage stage;
  stage.knows_enable = true;
  Bench bench(stage);
  const auto axis = bench.Homed();
  EXPECT_THAT(bench.heard.Text(), HasSubstr("EAX 1 1\n"));
  bench.stage.Receive("EAX 1 0\n");
  EXPECT_EQ(axis->StartMove(1).error().message,
            "arm: is not homed since: the motor was without power");
}

// Example failure is a driver that calls a move ended while the stage still swings in.
TEST(Gcs2Axis, WaitsUntilItIsOnTarget) {
  Bench bench;
  const auto axis = bench.Homed();
  const Seconds begin = bench.clock->Now();
  const auto takes = axis->StartMove(0.001);
  ASSERT_TRUE(takes.ok());
  ASSERT_TRUE(axis->WaitUntilStill(Seconds(60), {}).ok());
  EXPECT_NEAR(axis->State()->position, 0.001, 1e-4);
  EXPECT_GE((bench.clock->Now() - begin).count(), 0.2);
}

// Example failure is a driver that believes that a command was obeyed because nothing came back.
TEST(Gcs2Line, NoticesThatACommandWasPassedOver) {
  Bench bench;
  const auto why = [&](const char* command) { return bench.line->Command(0, command).error(); };
  EXPECT_EQ(why("MOV 1 10").code, ErrorCode::kRefused);
  EXPECT_THAT(why("MOV 1 10").message, HasSubstr("refused MOV 1 10: not referenced, or servo off"));
  EXPECT_THAT(why("MOV 7 10").message, HasSubstr("no such axis"));
  const auto axis = bench.Homed();
  EXPECT_THAT(why("MOV 1 176").message, HasSubstr("position out of limits"));
  // What others did wrong before is not this command's fault, nor is a stop.
  bench.stage.Receive("XXX\n");
  EXPECT_TRUE(bench.line->Command(0, "VEL 1 10").ok());
  bench.stage.Receive("HLT 1\n");
  EXPECT_TRUE(bench.line->Command(0, "VEL 1 10").ok());
}

TEST(Gcs2Line, AsksAgainWhenNoErrorComesBackAtAll) {
  Bench bench;
  bench.stage.Receive("XXX 1\n");
  bench.stage.SkipNextError();
  ASSERT_TRUE(bench.line->Command(0, "VEL 1 10").ok());
  PtyServer server([](std::string_view) { return "\n"; });
  EXPECT_EQ(Line(OpenedPort(server), kWireReplyLimit).ReadErrors(0).error().code,
            ErrorCode::kProtocol);
}

TEST(Gcs2Line, ReadsRepliesOfSeveralLinesButNotWithoutEnd) {
  Gcs2Stage stage;
  stage.axes = {"1", "2", "3"};
  Bench bench(stage);
  EXPECT_EQ(*bench.line->Axes(0), (std::vector<std::string>{"1", "2", "3"}));
  std::string endless;
  for (int i = 0; i < 100; ++i) endless += "1 \n";
  PtyServer server([&](std::string_view) { return endless; });
  const auto axes = Line(OpenedPort(server), kWireReplyLimit).Axes(0);
  ASSERT_FALSE(axes.ok());
  EXPECT_EQ(axes.error().code, ErrorCode::kProtocol);
}

// Replies do not name the question. Example failure is a driver that takes "servo on: 1=1", which
// comes late, for a position.
TEST(Gcs2Line, DoesNotTakeALateReplyForTheNextOne) {
  std::string late;  // comes before the next reply, whatever is asked
  PtyServer server([&](std::string_view bytes) -> std::string {
    if (bytes == "SVO? 1\n") {
      late += "1=1\n";
      return {};
    }
    const char* const reply = bytes == "*IDN?\n"    ? kIdentity
                              : bytes == "POS? 1\n" ? "1=-12.5\n"
                                                    : "0\n";
    return std::exchange(late, {}) + reply;
  });
  Line line(OpenedPort(server), kWireReplyLimit);
  EXPECT_EQ(line.Flag(0, "SVO?", "1").error().code, ErrorCode::kTimeout);
  const auto position = line.Number(0, "POS?", "1");
  ASSERT_TRUE(position.ok()) << position.error().message;
  EXPECT_EQ(*position, -12.5);
}

TEST(Gcs2Line, RefusesRepliesOfAnotherForm) {
  PtyServer server(
      [](std::string_view bytes) { return bytes == "*IDN?\n" ? kIdentity : "1=12.5\n"; });
  Line line(OpenedPort(server), kWireReplyLimit);
  EXPECT_EQ(line.Flag(0, "SVO?", "1").error().message,
            server.path() + ": \"1=12.5\" is neither 0 nor 1, asked SVO? 1");
  EXPECT_EQ(line.Number(0, "POS?", "2").error().code, ErrorCode::kProtocol);
  EXPECT_EQ(line.Moving(0).error().message,
            server.path() + ": \"1=12.5\" does not answer #5, asked #5");
  EXPECT_EQ(line.Command(0, "SVO 1 1").error().code, ErrorCode::kProtocol);
}

// Whether it was obeyed nobody knows then.
TEST(Gcs2Line, DoesNotSendACommandAgainWhoseErrorDoesNotCome) {
  int asked = 0;
  Heard heard;
  PtyServer server([&](std::string_view bytes) -> std::string {
    heard.Add(bytes);
    return bytes == "ERR?\n" && ++asked == 1 ? "0\n" : "";
  });
  EXPECT_EQ(Line(OpenedPort(server), kWireReplyLimit).Command(0, "MVR 1 10").error().code,
            ErrorCode::kTimeout);
  server.HangUp();
  const std::string text = heard.Text();
  EXPECT_THAT(text, HasSubstr("MVR 1 10\n"));
  EXPECT_EQ(text.find("MVR"), text.rfind("MVR"));
}

// Example failure is a driver that asks for errors first, and stops nothing if no answer comes.
TEST(Gcs2Axis, SendsAStopBeforeItAsksAnything) {
  Bench bench;
  const auto axis = bench.Moving();
  bench.server.set_silent(true);
  EXPECT_EQ(axis->Stop().error().code, ErrorCode::kTimeout);
  EXPECT_FALSE(bench.Turns());
}

// Example failure is a driver whose stop is passed over as an unknown command.
TEST(Gcs2Axis, StopsOneThatKnowsNoHalt) {
  Gcs2Stage stage;
  stage.knows_halt = false;
  Bench bench(stage);
  const auto axis = bench.Moving();
  EXPECT_TRUE(axis->Stop().ok());
  EXPECT_LT(bench.stage.Shaft(), 1) << "it has run on to its target of 2";
  EXPECT_FALSE(bench.Turns());
}

TEST(Gcs2Axis, StopsHardInAnEmergencyAndKeepsItsReference) {
  Bench bench;
  const auto axis = bench.Moving();
  bench.heard.Clear();
  ASSERT_TRUE(axis->EmergencyStop().ok());
  EXPECT_EQ(bench.heard.Text().front(), '\x18');
  EXPECT_TRUE(axis->State()->homed);
  EXPECT_TRUE(axis->StartMove(1).ok());
}

TEST(Gcs2Axis, ReportsAMotionErrorAndLosesItsReference) {
  Bench bench;
  const auto axis = bench.Moving();
  bench.stage.Fail(-1024);
  const auto still = axis->WaitUntilStill(Seconds(60), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().code, ErrorCode::kProtocol);
  EXPECT_EQ(still.error().message,
            "arm: a move ended: motion error: position error too large, servo off");
  EXPECT_THAT(axis->StartMove(1).error().message, HasSubstr("is not homed since: motion error"));
  EXPECT_TRUE(axis->Home({}).ok());
  EXPECT_TRUE(axis->StartMove(1).ok());
}

// Example failure is a driver that loses the fault when a stop reads it, in another thread.
TEST(Gcs2Axis, KeepsAFaultThatAStopHasRead) {
  Bench bench;
  const auto axis = bench.Moving();
  bench.stage.Fail(216);
  ASSERT_TRUE(bench.line->ReadErrors(0).ok());
  ASSERT_TRUE(axis->Stop().ok());
  EXPECT_EQ(axis->WaitUntilStill(Seconds(60), {}).error().message,
            "arm: a move ended: limit switch");
}

// The controller's own word is enough at opening, but not after a homing that was broken off.
TEST(Gcs2Axis, IsHomedAsLongAsTheControllerSaysSo) {
  Bench bench;
  bench.Homed();
  const auto again = std::move(bench.Open()).value();
  EXPECT_TRUE(again->State()->homed);
  bench.stage.Reset();
  bench.stage.Receive("SVO 1 1\n");  // by somebody else
  EXPECT_FALSE(again->State()->homed);
  EXPECT_EQ(again->StartMove(1).error().message, "arm: is not homed");
  bench.heard.Clear();
  ASSERT_TRUE(again->Home({}).ok());
  // A reset forgets them.
  EXPECT_THAT(bench.heard.Text(), HasSubstr("VEL 1 28.647890\n"));
  EXPECT_THAT(bench.heard.Text(), HasSubstr("ACC 1 57.295780\n"));
  EXPECT_THAT(bench.heard.Text(), HasSubstr("DEC 1 57.295780\n"));
}

}  // namespace
}  // namespace gonio::gcs2
