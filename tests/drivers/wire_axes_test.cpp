// SPDX-License-Identifier: Apache-2.0
// What every motion driver does, over the real serial library, with its controller emulated at the
// other end of a pseudo-terminal: the promises of drivers/axis.h, and what becomes of faults that
// all wires and controllers have.
#include <gmock/gmock.h>

#include "drivers/grbl_axis.h"
#include "drivers/smc100_axis.h"
#include "drivers/zaber_axis.h"
#include "sim/grbl_emulator.h"
#include "sim/smc100_emulator.h"
#include "sim/zaber_emulator.h"
#include "tests/conformance/axis.h"
#include "tests/drivers/wire_axis.h"

namespace gonio {
namespace {

using testing::HasSubstr;

constexpr double kZero = 0.3;  // rad

// An axis and what can happen to it. Members are destroyed last to first: the driver before the
// line, the line before the device.
struct WireSubject {
  std::shared_ptr<ManualClock> clock = std::make_shared<ManualClock>();
  std::function<double()> mark_to_shaft;  // rad
  std::function<void()> lose_power;       // and have it again
  std::function<void()> cut_motor_power;
  std::function<void()> stop_by_hand;
  std::shared_ptr<PtyServer> line;
  std::unique_ptr<Axis> axis;
  bool answers_stops = true;
};
using WireFactory = std::function<WireSubject(bool turned)>;

template <typename Emulator, typename Open>
WireSubject Subject(bool turned, auto stage_settings, const char* stop_command, Open open) {
  WireSubject subject;
  auto stage = std::make_shared<Emulator>(stage_settings, subject.clock);
  subject.mark_to_shaft = [stage] { return stage->Shaft(); };
  subject.lose_power = [stage] { stage->Reset(); };
  subject.cut_motor_power = [stage] { stage->CutMotorPower(); };
  subject.stop_by_hand = [stage, stop_command] { stage->Receive(stop_command); };
  subject.line = std::make_shared<PtyServer>(
      [stage](std::string_view bytes) { return stage->Receive(bytes); });
  ControllerAxisSettings settings = ArmSettings();
  settings.scale.zero = kZero;
  settings.scale.turned = turned;
  auto axis = open(OpenedPort(*subject.line), settings, subject.clock.get());
  EXPECT_TRUE(axis.ok()) << axis.error().message;
  subject.axis = std::move(axis).value();
  return subject;
}

WireSubject Zaber(bool turned) {
  return Subject<ZaberEmulator>(
      turned, ZaberStage{}, "/1 1 stop\n",
      [](std::unique_ptr<ByteLink> link, const auto& settings, Clock* clock) {
        auto chain = std::make_shared<zaber::Chain>(std::move(link), kWireReplyLimit);
        return zaber::OpenAxis(std::move(chain), {}, settings, clock);
      });
}

WireSubject Smc100(bool turned) {
  return Subject<Smc100Emulator>(
      turned, Smc100Stage{}, "1ST\r\n",
      [](std::unique_ptr<ByteLink> link, const auto& settings, Clock* clock) {
        auto line = std::make_shared<smc100::Line>(std::move(link), kWireReplyLimit);
        return smc100::OpenAxis(std::move(line), 1, settings, clock);
      });
}

// Its coordinates end at 0, so that it has a zero of its own.
WireSubject Grbl(bool turned) {
  const double zero = turned ? -2.1 : 2.6;
  WireSubject subject;
  auto board = std::make_shared<GrblEmulator>(GrblBoard{}, subject.clock);
  subject.mark_to_shaft = [=] { return board->Shaft() + (turned ? -1 : 1) * (zero - kZero); };
  subject.lose_power = [board] { board->Reset(); };
  subject.cut_motor_power = [board] { board->CutMotorPower(); };
  subject.stop_by_hand = [board] { board->Receive("\x85"); };
  subject.answers_stops = false;
  subject.line =
      std::make_shared<PtyServer>([board](std::string_view bytes) { return board->Receive(bytes); },
                                  [board] { return board->Unasked(); });
  auto port = OpenedPort(*subject.line);
  board->Reset();
  auto machine = grbl::Machine::Open(std::move(port), subject.clock.get(),
                                     {.reply = kWireReplyLimit, .boot = Seconds(5)});
  EXPECT_TRUE(machine.ok()) << machine.error().message;
  ControllerAxisSettings settings = ArmSettings();
  settings.scale.zero = zero;
  settings.scale.turned = turned;
  auto axis = grbl::OpenAxis(*machine, 'X', settings, subject.clock.get());
  EXPECT_TRUE(axis.ok()) << axis.error().message;
  subject.axis = std::move(axis).value();
  return subject;
}

AxisFactory Promised(const WireFactory& make, bool turned) {
  return [make, turned] {
    WireSubject wire = make(turned);
    AxisSubject subject;
    subject.clock = wire.clock;
    // The line is kept as long as somebody may still pull its plug or look at the shaft.
    subject.shaft = [line = wire.line, shaft = wire.mark_to_shaft, turned] {
      return kZero + (turned ? -1 : 1) * shaft();
    };
    subject.pull_plug = [line = wire.line] { line->HangUp(); };
    subject.axis = std::move(wire.axis);
    return subject;
  };
}

INSTANTIATE_TEST_SUITE_P(Zaber, AxisConformance,
                         testing::Values(Promised(Zaber, false), Promised(Zaber, true)));
INSTANTIATE_TEST_SUITE_P(Smc100, AxisConformance,
                         testing::Values(Promised(Smc100, false), Promised(Smc100, true)));
INSTANTIATE_TEST_SUITE_P(Grbl, AxisConformance,
                         testing::Values(Promised(Grbl, false), Promised(Grbl, true)));

class WireFaults : public testing::TestWithParam<WireFactory> {
 protected:
  void SetUp() override {
    subject_ = GetParam()(false);
    ASSERT_TRUE(axis().Home({}).ok());
  }
  Axis& axis() { return *subject_.axis; }
  void StartMoving() {
    ASSERT_TRUE(axis().StartMove(2).ok());
    subject_.clock->SleepFor(Seconds(0.5));
  }

  WireSubject subject_;
};

TEST_P(WireFaults, SilenceIsATimeout) {
  subject_.line->set_silent(true);
  EXPECT_EQ(axis().State().error().code, ErrorCode::kTimeout);
  EXPECT_EQ(axis().StartMove(1).error().code, ErrorCode::kTimeout);
  EXPECT_EQ(axis().WaitUntilStill(Seconds(1), {}).error().code, ErrorCode::kTimeout);
  EXPECT_EQ(axis().Stop().error().code, ErrorCode::kTimeout);
  subject_.line->set_silent(false);
  EXPECT_TRUE(axis().State().ok());
}

TEST_P(WireFaults, QuestionsAreAskedAgainAndCommandsAreNot) {
  subject_.line->Garble(1);
  EXPECT_TRUE(axis().State().ok());
  subject_.line->Garble(2);
  EXPECT_EQ(axis().State().error().code, ErrorCode::kProtocol);
  subject_.line->Garble(1);
  const auto stopped = axis().Stop();
  // Where a stop is not answered, only the question whether it stands can be garbled.
  ASSERT_EQ(stopped.ok(), !subject_.answers_stops);
  EXPECT_TRUE(stopped.ok() || stopped.error().code == ErrorCode::kProtocol);
}

TEST_P(WireFaults, AResetLosesTheReference) {
  StartMoving();
  subject_.lose_power();
  const auto still = axis().WaitUntilStill(Seconds(60), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().message, "arm: lost its reference on the way");
  EXPECT_FALSE(axis().State()->homed);
  EXPECT_EQ(axis().StartMove(1).error().message, "arm: is not homed");
  EXPECT_TRUE(axis().Home({}).ok());
  EXPECT_TRUE(axis().StartMove(1).ok());
}

// As an emergency stop does. Example failure is a driver that gives it back by itself.
TEST_P(WireFaults, WithoutMotorPowerItIsNotHomedUntilItIsHomedAgain) {
  StartMoving();
  subject_.cut_motor_power();
  const auto still = axis().WaitUntilStill(Seconds(60), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().code, ErrorCode::kProtocol);
  EXPECT_EQ(axis().StartMove(1).error().message,
            "arm: is not homed since: the motor was without power");
  EXPECT_TRUE(axis().Home({}).ok());
  EXPECT_TRUE(axis().StartMove(1).ok());
}

TEST_P(WireFaults, StoppedShortOfItsTargetItHasNotArrived) {
  StartMoving();
  subject_.stop_by_hand();
  const auto still = axis().WaitUntilStill(Seconds(60), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(still.error().message, HasSubstr("instead of 114.592 deg"));
}

INSTANTIATE_TEST_SUITE_P(Zaber, WireFaults, testing::Values(Zaber));
INSTANTIATE_TEST_SUITE_P(Smc100, WireFaults, testing::Values(Smc100));
INSTANTIATE_TEST_SUITE_P(Grbl, WireFaults, testing::Values(Grbl));

}  // namespace
}  // namespace gonio
