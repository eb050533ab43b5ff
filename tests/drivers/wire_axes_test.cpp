// SPDX-License-Identifier: Apache-2.0
// What every motion driver does, over the real serial library, with its controller emulated at the
// other end of a pseudo-terminal: the promises of drivers/axis.h, and what becomes of faults that
// all wires and controllers have.
#include <gmock/gmock.h>

#include <optional>

#include "drivers/apt_axis.h"
#include "drivers/esp301_axis.h"
#include "drivers/gcs2_axis.h"
#include "drivers/grbl_axis.h"
#include "drivers/smc100_axis.h"
#include "drivers/zaber_axis.h"
#include "sim/apt_emulator.h"
#include "sim/esp301_emulator.h"
#include "sim/gcs2_emulator.h"
#include "sim/grbl_emulator.h"
#include "sim/smc100_emulator.h"
#include "sim/zaber_emulator.h"
#include "tests/conformance/axis.h"
#include "tests/drivers/wire_axis.h"

namespace gonio {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

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
  // So many garbled answers in a row are too many for a question, which is then an error; and what
  // becomes of a stop after which one is garbled: no error where nothing needs to be understood.
  int too_many_garbled = 2;
  ErrorCode garbled_question = ErrorCode::kProtocol;
  std::optional<ErrorCode> garbled_stop = ErrorCode::kProtocol;
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

WireSubject Apt(bool turned, const AptStage& controller, const char* stage) {
  return Subject<AptEmulator>(
      turned, controller, "\x65\x04\x01\x02\x50\x01",
      [stage](std::unique_ptr<ByteLink> link, const auto& settings, Clock* clock) {
        auto shared = std::make_shared<apt::Link>(std::move(link), kWireReplyLimit);
        return apt::OpenAxis(std::move(shared), {}, stage, settings, clock);
      });
}
WireSubject AptServo(bool turned) { return Apt(turned, AptStage{}, "PRM1-Z8"); }
WireSubject AptStepper(bool turned) { return Apt(turned, K10cr1(), "K10CR1"); }

WireSubject Esp301(bool turned) {
  return Subject<Esp301Emulator>(
      turned, Esp301Stage{}, "1ST\r",
      [](std::unique_ptr<ByteLink> link, const auto& settings, Clock* clock) {
        auto line = std::make_shared<esp301::Line>(std::move(link), kWireReplyLimit);
        return esp301::OpenAxis(std::move(line), {}, settings, clock);
      });
}

// Its shortest replies are a digit and the end of the line. Where that end is garbled it is missed
// until the time is over; where there are two digits the second turns into another, and only a stop
// that does not care which error it is can be told so.
WireSubject Gcs2(bool turned) {
  WireSubject subject = Subject<Gcs2Emulator>(
      turned, Gcs2Stage{}, "HLT 1\n",
      [](std::unique_ptr<ByteLink> link, const auto& settings, Clock* clock) {
        auto line = std::make_shared<gcs2::Line>(std::move(link), kWireReplyLimit);
        return gcs2::OpenAxis(std::move(line), {}, settings, clock);
      });
  subject.too_many_garbled = 100;
  subject.garbled_question = ErrorCode::kTimeout;
  subject.garbled_stop = std::nullopt;
  return subject;
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
  subject.garbled_stop = std::nullopt;  // nothing answers it
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
INSTANTIATE_TEST_SUITE_P(AptServo, AxisConformance,
                         testing::Values(Promised(AptServo, false), Promised(AptServo, true)));
INSTANTIATE_TEST_SUITE_P(AptStepper, AxisConformance,
                         testing::Values(Promised(AptStepper, false), Promised(AptStepper, true)));
INSTANTIATE_TEST_SUITE_P(Esp301, AxisConformance,
                         testing::Values(Promised(Esp301, false), Promised(Esp301, true)));
INSTANTIATE_TEST_SUITE_P(Gcs2, AxisConformance,
                         testing::Values(Promised(Gcs2, false), Promised(Gcs2, true)));
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
  subject_.line->Garble(subject_.too_many_garbled);
  EXPECT_EQ(axis().State().error().code, subject_.garbled_question);
  subject_.line->Garble(1);
  const auto stopped = axis().Stop();
  if (subject_.garbled_stop) {
    EXPECT_EQ(stopped.error().code, *subject_.garbled_stop);
  } else {
    EXPECT_TRUE(stopped.ok());
  }
}

TEST_P(WireFaults, AResetLosesTheReference) {
  StartMoving();
  subject_.lose_power();
  const auto still = axis().WaitUntilStill(Seconds(60), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().message, "arm: lost its reference on the way");
  EXPECT_FALSE(axis().State()->homed);
  // A motor that comes back without power is one more reason.
  EXPECT_THAT(axis().StartMove(1).error().message, StartsWith("arm: is not homed"));
  EXPECT_TRUE(axis().Home({}).ok());
  EXPECT_TRUE(axis().StartMove(1).ok());
}

// Example failure is a driver that first asks how things are, and gives up when nobody answers.
TEST_P(WireFaults, AStopIsSentEvenIfNobodyAnswers) {
  StartMoving();
  subject_.line->set_silent(true);
  EXPECT_EQ(axis().Stop().error().code, ErrorCode::kTimeout);
  const double shaft = subject_.mark_to_shaft();
  subject_.clock->SleepFor(Seconds(1));
  EXPECT_EQ(subject_.mark_to_shaft(), shaft);
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
INSTANTIATE_TEST_SUITE_P(AptServo, WireFaults, testing::Values(AptServo));
INSTANTIATE_TEST_SUITE_P(AptStepper, WireFaults, testing::Values(AptStepper));
INSTANTIATE_TEST_SUITE_P(Esp301, WireFaults, testing::Values(Esp301));
INSTANTIATE_TEST_SUITE_P(Gcs2, WireFaults, testing::Values(Gcs2));
INSTANTIATE_TEST_SUITE_P(Grbl, WireFaults, testing::Values(Grbl));

}  // namespace
}  // namespace gonio
