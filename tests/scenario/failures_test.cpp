// SPDX-License-Identifier: Apache-2.0
// What a session does about failures, as the rig file's `failures` has it.

#include <gmock/gmock.h>

#include "acquisition/failure_policy.h"
#include "acquisition/session_history.h"
#include "acquisition/session_record.h"
#include "tests/core/temp_dir.h"
#include "tests/scenario/bench.h"
#include "tests/scenario/faulty_devices.h"

namespace gonio {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A steady rig whose devices fail as `script` says, and what came of a session on it.
class FailingBench : public SteadyBench {
 public:
  SessionSummary RunWith(const SessionStop& stop = {}, const SessionOptions& options = {}) {
    FaultyRig faulty(devices, [&](const std::string& device, const std::string& call) {
      return script ? script(device, call) : std::nullopt;
    });
    EventLog log = EventLog::Create(dir / "s", SomeInfo());

    SessionParts parts{
        .rig = rig, .devices = devices, .clock = clock, .planner = planner, .log = &log};
    parts.draw = draw;
    parts.reopen = [&](FailureClass failure) -> Result<void> {
      reopened.push_back(failure);
      if (lose_light) {
        devices.light.reset();
        return Error{ErrorCode::kDisconnected, "no such port"};
      }
      if (!cable) return Error{ErrorCode::kDisconnected, "no such port"};
      faulty.Reopen(failure);
      return {};
    };
    parts.on_event = [&](const SessionNotice& notice) { notices.push_back(notice.kind); };
    parts.on_state = [&](SessionState state) {
      if (states.empty() || states.back() != state) states.push_back(state);
    };
    return RunSession(parts, options, stop);
  }

  // Fails the `n`-th call (1, 2, ...) of that kind, and those up to `until`.
  void FailCall(const std::string& of, const std::string& call, int n, ErrorCode code,
                int until = 0) {
    script = [=, this, count = 0](const std::string& device,
                                  const std::string& called) mutable -> std::optional<Error> {
      if (device != of || called != call) return std::nullopt;
      ++count;
      if (count < n || count > std::max(n, until)) return std::nullopt;
      return Error{code, "planted"};
    };
  }

  const TempDir dir;
  ScriptedPlanner planner{FourPoses()};
  FaultScript script;
  bool lose_light = false;  // it is closed, and cannot be opened
  bool cable = true;        // whether what was unplugged is there again
  std::vector<FailureClass> reopened;
  std::vector<std::string> notices;
  std::vector<SessionState> states;
};

std::vector<std::string> KindsOf(const SessionRecord& record) {
  std::vector<std::string> kinds;
  for (const SessionEvent& event : record.events) kinds.push_back(event.kind);
  return kinds;
}

// What the same session measures if nothing fails.
std::vector<BrdfSample> Undisturbed() {
  FailingBench bench;
  EXPECT_EQ(bench.RunWith().outcome, SessionOutcome::kComplete);
  return bench.planner.observed;
}

void ExpectSame(const std::vector<BrdfSample>& a, const std::vector<BrdfSample>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_TRUE((a[i].f_r == b[i].f_r).all()) << i;
    EXPECT_EQ(a[i].directions.wi, b[i].directions.wi) << i;
  }
}

// Example failure is a session that ends, and with it the night, because a camera was unplugged for
// a second.
TEST(Failures, ACameraThatIsGoneIsOpenedAnewAndThePoseRepeated) {
  FailingBench bench;
  bench.FailCall("camera", "Capture", 4, ErrorCode::kDisconnected);
  const SessionSummary summary = bench.RunWith();
  EXPECT_EQ(summary.outcome, SessionOutcome::kComplete) << summary.reason;
  EXPECT_THAT(bench.reopened, ElementsAre(FailureClass::kInstrument));
  ExpectSame(bench.planner.observed, Undisturbed());
  const SessionRecord record = ReadSession(bench.dir / "s");
  EXPECT_THAT(KindsOf(record), Contains("failure").Times(1));
  EXPECT_THAT(KindsOf(record), Contains("recovered").Times(1));
  EXPECT_THAT(KindsOf(record), Contains("resume_reference").Times(1));
  EXPECT_THAT(bench.states, Contains(SessionState::kDisconnected));
  EXPECT_EQ(bench.states.back(), SessionState::kEnded);
  EXPECT_THAT(bench.notices, testing::IsSupersetOf({"failure", "recovered", "session_end"}));
}

TEST(Failures, AnInstrumentThatStaysAwayEndsTheSessionAfterItsRetries) {
  FailingBench bench;
  bench.cable = false;
  bench.FailCall("monitor", "Read", 3, ErrorCode::kDisconnected);
  const Seconds begin = bench.clock.Now();
  const SessionSummary summary = bench.RunWith();
  EXPECT_EQ(summary.outcome, SessionOutcome::kDeviceFault);
  EXPECT_THAT(summary.reason, HasSubstr("no such port"));
  EXPECT_EQ(bench.reopened.size(), 3u);
  EXPECT_GT(bench.clock.Now() - begin, 3 * bench.rig.failures.instrument.wait);
  EXPECT_EQ(bench.states.back(), SessionState::kFault);
  EXPECT_FALSE(bench.AnythingMoves());
}

// Nobody knows where the arms stopped: homing is for those who said that it is safe.
TEST(Failures, AnAxisIsNotHomedUnlessTheRigFileSaysSo) {
  FailingBench bench;
  bench.FailCall("light_azimuth", "WaitUntilStill", 2, ErrorCode::kProtocol);
  const SessionSummary summary = bench.RunWith();
  EXPECT_EQ(summary.outcome, SessionOutcome::kDeviceFault);
  EXPECT_THAT(bench.reopened, IsEmpty());
}

TEST(Failures, AnAxisIsHomedAndTheSessionMakesTheSameChoices) {
  FailingBench bench;
  bench.rig.failures.axis.retries = 2;
  bench.FailCall("camera_elevation", "WaitUntilStill", 2, ErrorCode::kProtocol);
  const SessionSummary summary = bench.RunWith();
  EXPECT_EQ(summary.outcome, SessionOutcome::kComplete) << summary.reason;
  EXPECT_THAT(bench.reopened, ElementsAre(FailureClass::kAxis));
  ExpectSame(bench.planner.observed, Undisturbed());
}

// Example failure is a pose kept whose arm may have sunk while it was exposed.
TEST(Failures, AMotorThatLosesPowerDuringAnExposureCostsThePose) {
  FailingBench bench;
  bench.rig.failures.axis.retries = 1;
  SimAxis& arm = bench.axis(kLightElevation);
  bool once = false;
  bench.camera->on_capture = [&](int) {
    if (bench.planner.observed.size() != 2 || once) return;
    once = true;
    arm.LosePower();
  };
  const SessionSummary summary = bench.RunWith();
  EXPECT_EQ(summary.outcome, SessionOutcome::kComplete) << summary.reason;
  EXPECT_THAT(bench.reopened, ElementsAre(FailureClass::kAxis));
  ExpectSame(bench.planner.observed, Undisturbed());
}

// Example failure is a count of attempts that begins anew with each of them.
TEST(Failures, AFailureThatComesAgainDuringRecoveryCountsAsWell) {
  FailingBench bench;
  bench.rig.failures.axis.retries = 3;
  int homings = 0;
  bench.script = [&](const std::string& device, const std::string& call) -> std::optional<Error> {
    if (device == "light_azimuth" && call == "Home" && ++homings > 1) {
      return Error{ErrorCode::kTimeout, "planted"};
    }
    if (device == "camera_azimuth" && call == "WaitUntilStill" && homings == 1) {
      return Error{ErrorCode::kProtocol, "planted"};
    }
    return std::nullopt;
  };
  const SessionSummary summary = bench.RunWith();
  EXPECT_EQ(summary.outcome, SessionOutcome::kDeviceFault);
  EXPECT_THAT(summary.reason, HasSubstr("Home: planted"));
  EXPECT_EQ(homings, 4);
}

TEST(Failures, ASkippedPoseIsToldToThePlanner) {
  FailingBench bench;
  bench.rig.failures.instrument = {.retries = 1, .wait = Seconds(1), .then = FailureAction::kSkip};
  // The second pose, both times; the reference between them goes well.
  bench.script = [&](const std::string& device, const std::string& call) -> std::optional<Error> {
    const bool second = bench.planner.observed.size() == 1 && bench.planner.rejected.empty();
    if (device != "camera" || call != "Capture" || !second) return std::nullopt;
    const bool reference = bench.states.back() == SessionState::kDisconnected;
    if (reference) return std::nullopt;
    return Error{ErrorCode::kTimeout, "planted"};
  };
  const SessionSummary summary = bench.RunWith();
  EXPECT_EQ(summary.outcome, SessionOutcome::kComplete) << summary.reason;
  EXPECT_THAT(bench.planner.rejected, ElementsAre(1));
  EXPECT_EQ(summary.poses.size(), 3u);
  EXPECT_EQ(bench.reopened.size(), 2u);
}

TEST(Failures, APersonIsCalledAndGoesOn) {
  FailingBench bench;
  bench.rig.failures.instrument = {.retries = 0, .wait = Seconds(1), .then = FailureAction::kPause};
  bench.FailCall("light", "SetLevel", 1, ErrorCode::kProtocol);  // homing is not paused for
  EXPECT_EQ(bench.RunWith().outcome, SessionOutcome::kDeviceFault);

  FailingBench again;
  again.rig.failures.instrument = bench.rig.failures.instrument;
  again.FailCall("camera", "Capture", 3, ErrorCode::kProtocol);
  int called = 0;
  const SessionStop stop{.after_pose = {}, .now = {}, .pause = {}, .wait = [&] {
                           ++called;
                           EXPECT_EQ(again.states.back(), SessionState::kPaused);
                           EXPECT_FALSE(again.AnythingMoves());
                         }};
  const SessionSummary summary = again.RunWith(stop);
  EXPECT_EQ(summary.outcome, SessionOutcome::kComplete) << summary.reason;
  EXPECT_EQ(called, 1);
  EXPECT_THAT(again.notices, Contains("person_called"));
  ExpectSame(again.planner.observed, Undisturbed());
}

TEST(Failures, APersonEndsIt) {
  FailingBench bench;
  bench.rig.failures.pose.then = FailureAction::kPause;
  bench.planner = ScriptedPlanner({Degrees(5, 20), OutOfReach(), Degrees(30, 40)});
  std::stop_source user;
  const SessionSummary summary =
      bench.RunWith({.after_pose = user.get_token(), .now = {}, .pause = {}, .wait = [&] {
                       user.request_stop();
                     }});
  EXPECT_EQ(summary.outcome, SessionOutcome::kStopped);
  EXPECT_EQ(summary.poses.size(), 1u);
}

TEST(Failures, TooManyInARowEndIt) {
  FailingBench bench;
  bench.rig.failures.instrument = {
      .retries = 100, .wait = Seconds(1), .then = FailureAction::kStop};
  bench.rig.failures.max_in_a_row = 5;
  bench.FailCall("camera", "Capture", 3, ErrorCode::kTimeout, 1000);
  const SessionSummary summary = bench.RunWith();
  EXPECT_EQ(summary.outcome, SessionOutcome::kDeviceFault);
  EXPECT_EQ(bench.reopened.size(), 4u);
}

TEST(Failures, AnEmergencyStopIsNeverTriedAgain) {
  FailingBench bench;
  bench.rig.failures.axis = {.retries = 5, .wait = Seconds(1), .then = FailureAction::kPause};
  bench.FailCall("camera_azimuth", "WaitUntilStill", 2, ErrorCode::kEmergencyStop);
  const SessionSummary summary = bench.RunWith();
  EXPECT_EQ(summary.outcome, SessionOutcome::kEmergencyStop);
  EXPECT_EQ(bench.states.back(), SessionState::kEmergencyStop);
  EXPECT_THAT(bench.reopened, IsEmpty());
  EXPECT_EQ(ReadSession(bench.dir / "s").end->outcome, "emergency stop");
  EXPECT_FALSE(bench.devices.axes[kCameraAzimuth]->State()->homed);
}

// Example failure is a session that says it is complete and leaves the lamp on.
TEST(Failures, ALightThatCannotBeSwitchedOffIsAFailureOfItsOwn) {
  FailingBench bench;
  bench.FailCall("light", "SetLevel", 2, ErrorCode::kTimeout, 1000);
  const Seconds begin = bench.clock.Now();
  const SessionSummary summary = bench.RunWith();
  EXPECT_EQ(summary.poses.size(), 4u);
  EXPECT_TRUE(summary.clean_up_failed);
  EXPECT_EQ(summary.outcome, SessionOutcome::kDeviceFault);
  EXPECT_THAT(summary.reason, HasSubstr("the light may still be on: light: SetLevel: planted"));
  EXPECT_EQ(bench.states.back(), SessionState::kFault);
  EXPECT_GT(bench.clock.Now() - begin, Seconds(30));  // it was tried for so long
  EXPECT_THAT(KindsOf(ReadSession(bench.dir / "s")), Contains("clean_up_failed"));
}

TEST(Failures, ALightThatIsSwitchedOffAtTheThirdTryIsNone) {
  FailingBench bench;
  bench.FailCall("light", "SetLevel", 2, ErrorCode::kTimeout, 3);
  EXPECT_EQ(bench.RunWith().outcome, SessionOutcome::kComplete);
  EXPECT_EQ(bench.lamp->level(), 0);
}

TEST(Failures, ArmsAreParkedIfTheUserWantsThat) {
  FailingBench bench;
  bench.rig.motion.park = std::array<double, 4>{0.1, 1.2, 3, 1.1};
  EXPECT_EQ(bench.RunWith({}, {.park = true}).outcome, SessionOutcome::kComplete);
  for (int i = 0; i < kAxes; ++i) {
    EXPECT_NEAR(bench.motors[i]->Position(), (*bench.rig.motion.park)[i], 1e-6) << i;
  }
  EXPECT_THAT(KindsOf(ReadSession(bench.dir / "s")), Contains("parked"));
}

// Example failure is an arm that sets off again after a stop at once.
TEST(Failures, ArmsThatWereStoppedAtOnceAreNotParked) {
  FailingBench bench;
  bench.rig.motion.park = std::array<double, 4>{0.1, 1.2, 3, 1.1};
  std::stop_source user;
  bench.camera->on_capture = [&](int n) {
    if (n == 3) user.request_stop();
  };
  const SessionSummary summary =
      bench.RunWith({.after_pose = {}, .now = user.get_token()}, {.park = true});
  EXPECT_EQ(summary.outcome, SessionOutcome::kStopped);
  EXPECT_GT(std::abs(bench.motors[kLightAzimuth]->Position() - 0.1), 1e-3);
}

// Example failure is an arm that failed and is sent off because the person who was called went
// home.
TEST(Failures, ArmsOfWhichOneFailedAreNotParked) {
  FailingBench bench;
  bench.rig.motion.park = std::array<double, 4>{0.1, 1.2, 3, 1.1};
  bench.rig.failures.axis.then = FailureAction::kPause;
  bench.script = [&, count = 0](const std::string& device,
                                const std::string& call) mutable -> std::optional<Error> {
    if (device != "camera_azimuth" || call != "StartMove" || ++count != 2) return std::nullopt;
    return Error{ErrorCode::kProtocol, "planted"};
  };
  std::stop_source user;
  const SessionSummary summary = bench.RunWith({.after_pose = user.get_token(),
                                                .now = {},
                                                .pause = {},
                                                .wait = [&] { user.request_stop(); }},
                                               {.park = true});
  EXPECT_EQ(summary.outcome, SessionOutcome::kStopped);
  EXPECT_GT(std::abs(bench.motors[kLightElevation]->Position() - 1.2), 1e-3);
  EXPECT_THAT(KindsOf(ReadSession(bench.dir / "s")), testing::Not(Contains("parked")));
}

// What was closed to be opened anew, and then was not.
TEST(Failures, ALightThatIsNotOpenAtTheEndIsSaid) {
  FailingBench bench;
  bench.FailCall("monitor", "Read", 3, ErrorCode::kDisconnected);
  bench.lose_light = true;
  const SessionSummary summary = bench.RunWith();
  EXPECT_EQ(summary.outcome, SessionOutcome::kDeviceFault);
  EXPECT_TRUE(summary.clean_up_failed);
  EXPECT_THAT(summary.warnings, Contains("the light may still be on: it is not open"));
}

TEST(FailuresConfig, IsReadFromARigFile) {
  const auto read = [](const std::string& text) {
    return ReadFailures(ConfigNode::Parse(text, "rig.yaml"));
  };
  EXPECT_EQ(read("a: 1\n").axis.retries, 0);
  EXPECT_EQ(read("a: 1\n").instrument.retries, 3);
  const FailuresConfig config = read(
      "failures:\n  pose: {retries: 1, then: pause}\n  axis: {retries: 2, wait_s: 30, then: stop}\n"
      "  instrument: {then: skip}\n  max_in_a_row: 4\n");
  EXPECT_EQ(config.pose.retries, 1);
  EXPECT_EQ(config.pose.then, FailureAction::kPause);
  EXPECT_EQ(config.axis.wait, Seconds(30));
  EXPECT_EQ(config.instrument.then, FailureAction::kSkip);
  EXPECT_EQ(config.instrument.retries, 3);
  EXPECT_EQ(config.max_in_a_row, 4);
  EXPECT_THAT(MessageOf<ConfigError>([&] { read("failures:\n  axis: {then: pray}\n"); }),
              HasSubstr("rig.yaml:2: failures.axis.then"));
}

}  // namespace
}  // namespace gonio
