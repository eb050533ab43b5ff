// SPDX-License-Identifier: Apache-2.0
#include "acquisition/interlocks.h"

#include <gmock/gmock.h>

#include "acquisition/session_history.h"
#include "acquisition/session_record.h"
#include "tests/core/temp_dir.h"
#include "tests/scenario/bench.h"

namespace gonio {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// A lamp that is dim for some time, as the monitor says.
class DimMonitor final : public Monitor {
 public:
  DimMonitor(std::unique_ptr<Monitor> monitor, const Clock& clock)
      : monitor_(std::move(monitor)), clock_(clock) {}
  const std::string& name() const override { return monitor_->name(); }
  const std::string& identity() const override { return monitor_->identity(); }
  Result<double> Read() override {
    auto reading = monitor_->Read();
    if (!reading) return reading;
    const bool dim = clock_.Now() >= from && clock_.Now() < until;
    return dim ? factor * *reading : *reading;
  }
  Seconds from{1e9};
  Seconds until{1e9};
  double factor = 0.5;

 private:
  const std::unique_ptr<Monitor> monitor_;
  const Clock& clock_;
};

InterlockSignal Lamp() {
  InterlockSignal lamp;
  lamp.name = "lamp";
  lamp.kind = InterlockSignal::Kind::kLamp;
  lamp.min = 0.8;
  lamp.hysteresis = 0.1;
  lamp.hold = Seconds(20);
  return lamp;
}

InterlockSignal Door(const std::filesystem::path& file) {
  InterlockSignal door;
  door.name = "door";
  door.kind = InterlockSignal::Kind::kFile;
  door.file = file;
  door.min = 1;
  return door;
}

class InterlockedBench : public Bench {
 public:
  InterlockedBench() {
    auto dim = std::make_unique<DimMonitor>(std::move(devices.monitor), clock);
    lamp_monitor = dim.get();
    devices.monitor = std::move(dim);
  }

  SessionSummary RunWith(InterlocksConfig config, EventLog* log = nullptr,
                         const SessionStop& stop = {}) {
    Interlocks interlocks(std::move(config), devices, clock, dir.path());
    interlocks.WatchWith(device_clock);
    ScriptedPlanner planner(FourPoses());
    planner.on_observe = on_observe;
    SessionParts parts{
        .rig = rig, .devices = devices, .clock = clock, .planner = planner, .log = log};
    parts.interlocks = &interlocks;
    parts.on_state = [&](SessionState state) {
      if (state == SessionState::kSuspended && on_suspended) on_suspended();
      if (states.empty() || states.back() != state) states.push_back(state);
    };
    return RunSession(parts, {.park = park}, stop);
  }

  const TempDir dir;
  bool park = false;
  DimMonitor* lamp_monitor = nullptr;
  std::function<void(int)> on_observe;
  std::function<void()> on_suspended;
  std::vector<SessionState> states;
};

std::vector<std::string> KindsOf(const SessionRecord& record) {
  std::vector<std::string> kinds;
  for (const SessionEvent& event : record.events) kinds.push_back(event.kind);
  return kinds;
}

// Example failure is a pose kept of which one frame was taken while the lamp was out of its band.
TEST(Interlocks, ADimLampSuspendsAndThePoseIsRepeated) {
  InterlockedBench bench;
  bench.on_observe = [&](int n) {
    if (n != 2) return;
    bench.lamp_monitor->from = bench.clock.Now() + Seconds(0.5);  // in the third pose
    bench.lamp_monitor->until = bench.lamp_monitor->from + Seconds(60);
  };
  SessionSummary summary;
  {
    EventLog log = EventLog::Create(bench.dir / "s", SomeInfo());
    summary = bench.RunWith({.signals = {Lamp()}}, &log);
  }
  EXPECT_EQ(summary.outcome, SessionOutcome::kComplete) << summary.reason;
  ASSERT_EQ(summary.poses.size(), 4u);
  const SessionRecord record = ReadSession(bench.dir / "s");
  EXPECT_THAT(
      KindsOf(record),
      ElementsAre("session_start", "prepared", "pose_measured", "pose_reduced", "pose_measured",
                  "pose_reduced", "pose_discarded", "suspended", "cleared", "resume_reference",
                  "pose_measured", "pose_reduced", "pose_measured", "pose_reduced", "session_end"));
  // It waited until the lamp had been well for the hold.
  EXPECT_GE(record.events[8].time, bench.lamp_monitor->until + Seconds(20));
  EXPECT_THAT(record.events[7].body, HasSubstr("must be >= 0.8"));
  for (const SessionPose& pose : summary.poses) {
    const Rgb truth = *bench.sample.Eval(pose.samples.front().directions);
    EXPECT_TRUE(((pose.samples.front().f_r - truth).abs() < 5 * pose.samples.front().sigma).all());
  }
  EXPECT_THAT(bench.states, testing::Contains(SessionState::kSuspended));
  EXPECT_EQ(HistoryOf(record).turns.size(), 4u);
}

// Below its minimum it trips; to be clear it has to be above it by the hysteresis.
TEST(Interlocks, HysteresisKeepsASignalAtTheEdgeFromFlickering) {
  InterlockedBench bench;
  Interlocks interlocks({.signals = {Lamp()}, .poll = Seconds(1), .longest_wait = Seconds(100)},
                        bench.devices, bench.clock, bench.dir.path());
  ASSERT_TRUE(bench.devices.light->SetLevel(1).ok());
  EXPECT_FALSE(interlocks.Check());
  bench.lamp_monitor->from = Seconds(0);
  bench.lamp_monitor->until = Seconds(1e9);
  bench.lamp_monitor->factor = 0.85;  // within the band, not within the hysteresis
  EXPECT_FALSE(interlocks.Check());
  const auto waited = interlocks.WaitUntilClear({});
  ASSERT_FALSE(waited.ok());
  EXPECT_EQ(waited.error().code, ErrorCode::kTimeout);
  EXPECT_THAT(waited.error().message, HasSubstr("lamp: is 0.8"));
  bench.lamp_monitor->factor = 0.95;
  EXPECT_TRUE(interlocks.WaitUntilClear({}).ok());
}

TEST(Interlocks, ADoorThatStaysOpenEndsTheSession) {
  InterlockedBench bench;
  const std::filesystem::path file = bench.dir.File("door", "1\n");
  bench.on_observe = [&](int n) {
    if (n == 1) bench.dir.File("door", "0\n");
  };
  const SessionSummary summary =
      bench.RunWith({.signals = {Door(file)}, .longest_wait = Seconds(600)});
  EXPECT_EQ(summary.outcome, SessionOutcome::kDeviceFault);
  EXPECT_THAT(summary.reason, HasSubstr("door: is 0, must be >= 1"));
  EXPECT_EQ(summary.poses.size(), 1u);
  EXPECT_FALSE(bench.AnythingMoves());
  EXPECT_EQ(bench.lamp->level(), 0);
}

// Example failure is an exposure watched at its begin only.
TEST(Interlocks, ADoorOpenedDuringAnExposureIsSeenAtItsEnd) {
  InterlockedBench bench;
  const std::filesystem::path file = bench.dir.File("door", "1\n");
  int opened = 0;
  bench.camera->on_capture = [&](int n) {
    if (n == 2) {
      ++opened;
      bench.dir.File("door", "0\n");
    } else {
      bench.dir.File("door", "1\n");
    }
  };
  Interlocks interlocks({.signals = {Door(file)}}, bench.devices, bench.clock, bench.dir.path());
  ASSERT_TRUE(bench.devices.light->SetLevel(1).ok());
  for (int i = 0; i < kAxes; ++i) ASSERT_TRUE(bench.devices.axes[i]->Home({}).ok());
  ASSERT_TRUE(bench.devices.camera->Capture(Seconds(0.1), {}).ok());
  EXPECT_FALSE(interlocks.Check());
  ASSERT_TRUE(bench.devices.camera->Capture(Seconds(0.1), {}).ok());
  ASSERT_TRUE(bench.devices.camera->Capture(Seconds(0.1), {}).ok());  // closed again
  const auto trip = interlocks.Check();
  EXPECT_EQ(opened, 1);
  ASSERT_TRUE(trip);
  EXPECT_EQ(trip->signal, "door");
}

TEST(Interlocks, AStopSignalEndsTheSessionAtOnce) {
  InterlockedBench bench;
  InterlockSignal button = Door(bench.dir.File("button", "1\n"));
  button.action = TripAction::kStop;
  bench.on_observe = [&](int n) {
    if (n == 2) std::filesystem::remove(button.file);  // what cannot be read is not met
  };
  const SessionSummary summary = bench.RunWith({.signals = {button}});
  EXPECT_EQ(summary.outcome, SessionOutcome::kDeviceFault);
  EXPECT_THAT(summary.reason, HasSubstr("door: cannot be read"));
  EXPECT_EQ(summary.poses.size(), 2u);
}

// Example failure is an arm that goes on to its target past an open door.
TEST(Interlocks, ADoorOpenedDuringAMoveStopsTheArmsWhereTheyAre) {
  InterlockedBench bench;
  const std::filesystem::path file = bench.dir.File("door", "1\n");
  InterlockSignal door = Door(file);
  door.action = TripAction::kStop;
  Interlocks interlocks({.signals = {door}}, bench.devices, bench.clock, bench.dir.path());
  interlocks.WatchWith(bench.device_clock);
  PoseMeasurer measurer(bench.rig, bench.devices, bench.clock);
  ASSERT_TRUE(measurer.Prepare({}).ok());
  std::stop_source source;
  int trips = 0;
  interlocks.SetOnTrip([&] {
    ++trips;
    source.request_stop();
  });
  const auto there = measurer.Measure(ToDirections(Degrees(60, 15)), {}, {});
  ASSERT_TRUE(there.ok());
  const Seconds begin = bench.clock.Now();
  bench.dir.File("door", "0\n");
  const auto gone = measurer.Measure(ToDirections(Degrees(5, 70)), {}, source.get_token());
  ASSERT_FALSE(gone.ok());
  EXPECT_EQ(gone.error().code, ErrorCode::kCancelled);
  EXPECT_GT(trips, 0);
  EXPECT_FALSE(bench.AnythingMoves());
  // Half a second of braking; the move takes several.
  EXPECT_LT(bench.clock.Now() - begin, Seconds(1));
}

TEST(Interlocks, ADoorOpenDuringAMoveSuspendsAndThePoseIsMeasuredAllTheSame) {
  InterlockedBench bench;
  const std::filesystem::path file = bench.dir.File("door", "1\n");
  bench.on_observe = [&](int n) {
    if (n == 2) bench.dir.File("door", "0\n");
  };
  InterlocksConfig config{.signals = {Door(file)}, .poll = Seconds(1)};
  const TempDir logs;
  SessionSummary summary;
  {
    EventLog log = EventLog::Create(logs / "s", SomeInfo());
    bench.on_suspended = [&] { bench.dir.File("door", "1\n"); };
    summary = bench.RunWith(config, &log);
  }
  EXPECT_EQ(summary.outcome, SessionOutcome::kComplete) << summary.reason;
  EXPECT_EQ(summary.poses.size(), 4u);
  EXPECT_THAT(KindsOf(ReadSession(logs / "s")), testing::Contains("suspended"));
}

// Example failure is a session that takes what the second opening stopped for the user's wish.
TEST(Interlocks, ADoorOpenedAgainDuringTheReferenceSuspendsOnceMore) {
  InterlockedBench bench;
  const std::filesystem::path file = bench.dir.File("door", "1\n");
  int suspended = 0;
  bench.on_observe = [&](int n) {
    if (n == 2) bench.dir.File("door", "0\n");
  };
  bench.on_suspended = [&] {
    ++suspended;
    bench.dir.File("door", "1\n");
  };
  bool again = false;
  bench.camera->on_capture = [&](int) {
    if (suspended != 1 || again) return;
    again = true;
    bench.dir.File("door", "0\n");
  };
  const SessionSummary summary = bench.RunWith({.signals = {Door(file)}, .poll = Seconds(1)});
  EXPECT_EQ(summary.outcome, SessionOutcome::kComplete) << summary.reason;
  EXPECT_EQ(summary.poses.size(), 4u);
  EXPECT_EQ(suspended, 2);
}

TEST(Interlocks, AnEmergencyStopEndsInAStateOfItsOwn) {
  InterlockedBench bench;
  InterlockSignal button = Door(bench.dir.File("button", "1\n"));
  button.action = TripAction::kEmergencyStop;
  bench.on_observe = [&](int n) {
    if (n == 2) bench.dir.File("button", "0\n");
  };
  const SessionSummary summary = bench.RunWith({.signals = {button}});
  EXPECT_EQ(summary.outcome, SessionOutcome::kEmergencyStop);
  EXPECT_THAT(summary.reason, HasSubstr("interlock door: is 0, must be >= 1"));
  EXPECT_EQ(bench.states.back(), SessionState::kEmergencyStop);
  EXPECT_EQ(bench.lamp->level(), 0);
}

// Example failure is an axis that is homed past an open door.
TEST(Interlocks, NothingMovesBeforeTheDoorIsClosed) {
  InterlockedBench bench;
  const std::filesystem::path file = bench.dir.File("door", "0\n");
  const double before = bench.motors[kLightAzimuth]->Position();
  const SessionSummary summary =
      bench.RunWith({.signals = {Door(file)}, .longest_wait = Seconds(600)});
  EXPECT_EQ(summary.outcome, SessionOutcome::kDeviceFault);
  EXPECT_THAT(summary.reason, HasSubstr("door: is 0"));
  EXPECT_EQ(bench.motors[kLightAzimuth]->Position(), before);
  EXPECT_GT(bench.clock.Now(), Seconds(599));
}

// Example failure is an arm that is parked past whoever opened the door, since the end was clean.
TEST(Interlocks, NothingIsParkedWhileADoorIsOpen) {
  InterlockedBench bench;
  bench.rig.motion.park = std::array<double, 4>{0.1, 1.2, 3, 1.1};
  bench.park = true;
  const std::filesystem::path file = bench.dir.File("door", "1\n");
  bench.on_observe = [&](int n) {
    if (n == 2) bench.dir.File("door", "0\n");
  };
  std::stop_source user;
  bench.on_suspended = [&] { user.request_stop(); };
  const SessionSummary summary = bench.RunWith({.signals = {Door(file)}}, nullptr,
                                               {.after_pose = user.get_token(), .now = {}});
  EXPECT_EQ(summary.outcome, SessionOutcome::kStopped);
  EXPECT_GT(std::abs(bench.motors[kLightElevation]->Position() - 1.2), 1e-3);
  EXPECT_THAT(summary.warnings,
              testing::Contains(HasSubstr("not parked: interlock door: is 0, must be >= 1")));
}

TEST(Interlocks, TheUserEndsASuspension) {
  InterlockedBench bench;
  std::stop_source user;
  bench.lamp_monitor->from = Seconds(0);
  SessionStop stop{.after_pose = user.get_token(), .now = {}};
  user.request_stop();
  const SessionSummary summary = bench.RunWith({.signals = {Lamp()}}, nullptr, stop);
  EXPECT_EQ(summary.outcome, SessionOutcome::kStopped);
  EXPECT_TRUE(summary.poses.empty());
}

TEST(Interlocks, AreReadFromARigFile) {
  const auto read = [](const std::string& text) {
    return ReadInterlocks(ConfigNode::Parse(text, "rig.yaml"), "/lab");
  };
  EXPECT_TRUE(read("a: 1\n").signals.empty());
  const InterlocksConfig config = read(
      "interlocks:\n  longest_wait_min: 5\n  signals:\n"
      "    - {name: door, signal: file, file: door, min: 1, when_tripped: stop}\n"
      "    - {name: disk, signal: disk, min: 500, hysteresis: 100, hold_s: 0}\n");
  EXPECT_EQ(config.longest_wait, Seconds(300));
  ASSERT_EQ(config.signals.size(), 2u);
  EXPECT_EQ(config.signals[0].file, "/lab/door");
  EXPECT_EQ(config.signals[0].action, TripAction::kStop);
  EXPECT_EQ(config.signals[1].hysteresis, 100);
  const auto complaint = [&](const std::string& signal) {
    return MessageOf<ConfigError>(
        [&] { read("interlocks:\n  signals:\n    - {name: x, " + signal + "}\n"); });
  };
  EXPECT_THAT(complaint("signal: lamp"), HasSubstr("this or max is needed"));
  EXPECT_THAT(complaint("signal: smell, min: 1"), HasSubstr("signal"));
  EXPECT_THAT(complaint("signal: file, min: 1"), HasSubstr("file"));
}

TEST(Interlocks, AFullDiskIsSeen) {
  InterlockedBench bench;
  InterlockSignal disk;
  disk.name = "disk";
  disk.kind = InterlockSignal::Kind::kDiskFree;
  disk.min = 1e12;  // a million terabytes
  Interlocks interlocks({.signals = {disk}}, bench.devices, bench.clock, bench.dir.path());
  const auto trip = interlocks.Check();
  ASSERT_TRUE(trip);
  EXPECT_THAT(trip->message, HasSubstr("disk: is "));
  disk.min = 1e-6;
  Interlocks roomy({.signals = {disk}}, bench.devices, bench.clock, bench.dir.path());
  EXPECT_FALSE(roomy.Check());
}

}  // namespace
}  // namespace gonio
