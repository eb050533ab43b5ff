// SPDX-License-Identifier: Apache-2.0
// What is peculiar to Thorlabs' controllers, and what the driver makes of it.
#include "drivers/apt_axis.h"

#include <gmock/gmock.h>

#include "core/units.h"
#include "sim/apt_emulator.h"
#include "tests/drivers/wire_axis.h"

namespace gonio::apt {
namespace {

using testing::HasSubstr;

AptStage WithSwitchAt(double deg) {
  AptStage stage;
  stage.switch_at_deg = deg;
  return stage;
}

// A controller, its line, and who talks to it.
SerialSettings RtsCts(const std::string& path) {
  SerialSettings settings;
  settings.port = path;
  settings.flow = SerialSettings::Flow::kRtsCts;
  return settings;
}

struct Bench {
  explicit Bench(const AptStage& settings = {}) : stage(settings, clock) {}

  Result<std::unique_ptr<Axis>> Open(const ControllerAxisSettings& settings = ArmSettings(),
                                     const char* name = "PRM1-Z8", const Address& address = {}) {
    return OpenAxis(link, address, name, settings, clock.get());
  }
  std::string WhyNot(const ControllerAxisSettings& settings, const char* name = "PRM1-Z8",
                     const Address& address = {}) {
    const auto axis = Open(settings, name, address);
    return axis.ok() ? "opened" : axis.error().message;
  }
  std::unique_ptr<Axis> Homed() {
    auto axis = Open();
    EXPECT_TRUE(axis.ok()) << axis.error().message;
    const auto homed = (*axis)->Home({});
    EXPECT_TRUE(homed.ok()) << homed.error().message;
    return std::move(axis).value();
  }
  std::unique_ptr<Axis> Moving() {
    auto axis = Homed();
    EXPECT_TRUE(axis->StartMove(2).ok());
    clock->SleepFor(Seconds(0.5));
    return axis;
  }
  std::string HowItEnded(Axis& axis) {
    const auto still = axis.WaitUntilStill(Seconds(60), {});
    return still.ok() ? "arrived" : still.error().message;
  }

  const std::shared_ptr<ManualClock> clock = std::make_shared<ManualClock>();
  AptEmulator stage;
  PtyServer line{[this](std::string_view bytes) { return stage.Receive(bytes); }};
  const std::shared_ptr<Link> link =
      std::make_shared<Link>(OpenPort(RtsCts(line.path()), clock.get()).value(), kWireReplyLimit);
};

TEST(AptAxis, RefusesWhatTheControllerCannotDo) {
  Bench bench;
  EXPECT_EQ(bench.WhyNot(ArmSettings(), "PRM1Z8"),
            "arm: \"PRM1Z8\" is no stage known here; known are PRM1-Z8, DDR100, DDR05, K10CR1, "
            "HDR50, NR360");
  EXPECT_EQ(bench.WhyNot(ArmSettings(), "DDR100"),
            "arm: KDC101 with serial number 27000042 does not drive a DDR100: the number would "
            "begin with one of 28, 67, 73, 103");
  ControllerAxisSettings settings = ArmSettings();
  settings.limits.max_speed = 1;
  EXPECT_EQ(bench.WhyNot(settings),
            "arm: maximum velocity and acceleration were set to 2460376 and 840 and read 1717666 "
            "and 840");
  settings.limits.max_speed = 1e-8;
  EXPECT_EQ(bench.WhyNot(settings),
            "arm: maximum velocity would be 0.0246038: it has 1 to 2147483647");
  settings = ArmSettings();
  settings.limits.acceleration = 1e9;
  EXPECT_EQ(bench.WhyNot(settings),
            "arm: acceleration would be 8.39956e+11: it has 1 to 2147483647");
  settings = ArmSettings();
  settings.limits.max_position = 1e5;
  EXPECT_THAT(bench.WhyNot(settings), HasSubstr("are outside the controller's own, -1.11869e+06 to "
                                                "1.11869e+06 deg (what its counter holds)"));
  EXPECT_EQ(
      bench.WhyNot(ArmSettings(), "PRM1-Z8", {.module = 0x21, .channel = 1}),
      "arm: " + bench.line.path() + ": no answer within 0.5 s, module 0x11, told HW_REQ_INFO");
  EXPECT_EQ(bench.stage.Shaft(), RadFromDeg(AptStage{}.switched_on_at_deg));
}

TEST(AptAxis, SaysWhatItIs) {
  Bench bench;
  const auto axis = bench.Open();
  ASSERT_TRUE(axis.ok());
  EXPECT_THAT((*axis)->identity(),
              testing::StartsWith("Thorlabs KDC101, serial 27000042, firmware"));
  EXPECT_THAT((*axis)->identity(), HasSubstr("as PRM1-Z8"));
}

// Of a rack the cards are spoken to, and the rack says who it is.
TEST(AptAxis, IsACardOfARack) {
  AptStage card;
  card.module = 0x22;
  card.serial = 73000009;
  card.model = "BBD102";
  card.counts_per_deg = 3276800 / 360.0;
  card.velocity_units = 61083.98;
  card.acceleration_units = 6.255;
  card.homing_velocity = 610839;
  Bench bench(card);
  const auto axis = bench.Open(ArmSettings(), "DDR100", {.module = 0x22, .channel = 1});
  ASSERT_TRUE(axis.ok()) << axis.error().message;
  EXPECT_THAT((*axis)->identity(), HasSubstr("BBD102, serial 73000009"));
  ASSERT_TRUE((*axis)->Home({}).ok());
  ASSERT_TRUE((*axis)->StartMove(1).ok());
  EXPECT_EQ(bench.HowItEnded(**axis), "arrived");
  EXPECT_NEAR(bench.stage.Shaft(), 1, 1e-4);
}

// Example failure is a driver that takes up backlash twice: the controller's is on by default.
TEST(AptAxis, SwitchesTheControllersBacklashOffAndAgainAfterPowerLoss) {
  Bench bench;
  const auto axis = bench.Open();
  ASSERT_TRUE(axis.ok());
  const std::int32_t velocity = bench.stage.max_velocity();
  EXPECT_EQ(bench.stage.backlash(), 0);
  bench.stage.Reset();
  EXPECT_NE(bench.stage.backlash(), 0);
  EXPECT_NE(bench.stage.max_velocity(), velocity);
  ASSERT_TRUE((*axis)->Home({}).ok());
  EXPECT_EQ(bench.stage.backlash(), 0);
  EXPECT_EQ(bench.stage.max_velocity(), velocity);
}

// Example failure is an axis that homes for ever, or until its time is over.
TEST(AptAxis, RefusesToHomeAtNoSpeed) {
  AptStage stage;
  stage.homing_velocity = 0;
  Bench bench(stage);
  const auto axis = bench.Open();
  ASSERT_TRUE(axis.ok());
  const auto homed = (*axis)->Home({});
  ASSERT_FALSE(homed.ok());
  EXPECT_EQ(homed.error().code, ErrorCode::kRefused);
  EXPECT_EQ(homed.error().message,
            "arm: its homing velocity is 0, so that homing would not end: set one with the maker's "
            "program");
}

// Example failure is a move that has "ended" before it began, and a homing that is over at once
// since the old reference still shows.
TEST(AptAxis, WaitsUntilTheStatusShowsWhatItWasTold) {
  AptStage stage;
  stage.sluggish = Seconds(0.3);
  Bench bench(stage);
  const auto axis = bench.Homed();
  ASSERT_TRUE(axis->StartMove(2).ok());
  EXPECT_TRUE(axis->State()->moving);
  EXPECT_EQ(bench.HowItEnded(*axis), "arrived");
  ASSERT_TRUE(axis->Home({}).ok());
  EXPECT_NEAR(bench.stage.Shaft(), 0, 1e-6);
}

// Example failure is an axis that is "homed" at the place where its homing was cancelled.
TEST(AptAxis, DoesNotBelieveAReferenceThatIsBeingLookedForAgain) {
  AptStage stage;
  stage.keeps_homed = true;
  Bench bench(stage);
  const auto axis = bench.Homed();
  ASSERT_TRUE(axis->StartMove(2).ok());
  ASSERT_EQ(bench.HowItEnded(*axis), "arrived");
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(axis->Home(stop.get_token()).error().code, ErrorCode::kCancelled);
  EXPECT_FALSE(axis->State()->homed);
  ASSERT_TRUE(axis->Home({}).ok());
  EXPECT_TRUE(axis->State()->homed);
  EXPECT_NEAR(bench.stage.Shaft(), 0, 1e-6);
}

// Example failure is a driver that is deaf after a minute.
// Example failure is the second session of a night, which finds the stage homed and at its mark,
// where homing takes no time that a status could show.
TEST(AptAxis, HomesWhereItStandsAtItsMark) {
  Bench bench;
  const auto axis = bench.Homed();
  const auto again = axis->Home({});
  EXPECT_TRUE(again.ok()) << again.error().message;
  EXPECT_TRUE(axis->State()->homed);
}

TEST(AptAxis, AcknowledgesStatuses) {
  Bench bench;
  const auto axis = bench.Homed();
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(axis->State().ok()) << i;
}

TEST(AptAxis, ReportsWhatTheStatusSays) {
  Bench bench;
  const auto axis = bench.Moving();
  bench.stage.Fail(0x4000);
  EXPECT_EQ(bench.HowItEnded(*axis), "arm: a move ended: motion error");
  EXPECT_EQ(axis->StartMove(1).error().message, "arm: is not homed since: motion error");
  ASSERT_TRUE(axis->Home({}).ok());
  EXPECT_TRUE(axis->StartMove(1).ok());
}

TEST(AptAxis, ReportsALimitSwitchThatEndedAMove) {
  Bench bench(WithSwitchAt(100));
  const auto axis = bench.Moving();
  EXPECT_EQ(bench.HowItEnded(*axis), "arm: a move ended: stopped at a limit switch");
}

// Example failure is a stage that cannot pass the switch at its reference mark.
TEST(AptAxis, PassesASwitchThatDoesNotStopIt) {
  Bench bench;
  const auto axis = bench.Moving();
  bench.stage.SetBits(0x2);
  EXPECT_EQ(bench.HowItEnded(*axis), "arrived");
  EXPECT_TRUE(axis->State()->homed);
}

// Whether the bit means open or closed, it does not change by itself.
TEST(AptAxis, ReportsAnInterlockThatChanges) {
  Bench bench;
  bench.stage.SetBits(0x10000);
  const auto axis = bench.Moving();
  EXPECT_TRUE(axis->State()->homed);
  bench.stage.SetBits(0);
  EXPECT_EQ(bench.HowItEnded(*axis), "arm: a move ended: its interlock has changed");
  EXPECT_TRUE(axis->Home({}).ok());
}

TEST(AptAxis, ReportsACommandThatTheControllerRefuses) {
  Bench bench;
  const auto axis = bench.Homed();
  bench.stage.Complain(0x0453, 10, "not while in manual mode");
  const auto started = axis->StartMove(1);
  ASSERT_FALSE(started.ok());
  EXPECT_EQ(started.error().code, ErrorCode::kRefused);
  EXPECT_EQ(started.error().message,
            "arm: " + bench.line.path() +
                ": refused with error 10: \"not while in manual mode\", module 0x50, told "
                "MOVE_ABSOLUTE");
  EXPECT_FALSE(axis->State()->moving);
  EXPECT_TRUE(axis->StartMove(1).ok());
}

// Example failure is a stage that is opened at the speed of whoever used it before.
TEST(AptAxis, RefusesToOpenWhereAQuestionOrACommandIsRefused) {
  Bench bench;
  for (const std::uint16_t message : {0x0005, 0x0413, 0x0414, 0x043a}) {
    bench.stage.Complain(message, 1, "no");
    EXPECT_THAT(bench.WhyNot(ArmSettings()), HasSubstr("refused with error 1: \"no\", module 0x50"))
        << message;
  }
  bench.stage.Complain(0, 1, "no");
  EXPECT_EQ(bench.WhyNot(ArmSettings()), "opened");
}

// Example failure is a driver that drops what it did not ask for.
TEST(AptAxis, ReportsErrorsThatComeUnasked) {
  Bench bench;
  const auto axis = bench.Moving();
  bench.stage.Complain(0, 7, "encoder lost");
  EXPECT_EQ(bench.HowItEnded(*axis),
            "arm: a move ended: its controller reports error 7: \"encoder lost\"");
  EXPECT_TRUE(axis->Home({}).ok());
  bench.stage.Complain();
  EXPECT_FALSE(axis->State()->homed);
  EXPECT_EQ(axis->StartMove(1).error().message,
            "arm: is not homed since: its controller reports an error it does not name");
}

// Another program may have asked for updates; they go on.
TEST(AptAxis, TellsAnswersFromWhatIsSaidUnasked) {
  Bench bench;
  bench.stage.Chatter();
  const auto axis = bench.Homed();
  for (const double target : {1.0, -1.0}) {
    ASSERT_TRUE(axis->StartMove(target).ok());
    EXPECT_EQ(bench.HowItEnded(*axis), "arrived");
    EXPECT_NEAR(bench.stage.Shaft(), target, 1e-4);
  }
}

TEST(AptAxis, IsStillHomedForTheNextProgram) {
  Bench bench;
  bench.Homed().reset();
  const auto axis = bench.Open();
  ASSERT_TRUE(axis.ok());
  EXPECT_TRUE((*axis)->State()->homed);
}

}  // namespace
}  // namespace gonio::apt
