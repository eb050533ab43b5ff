// SPDX-License-Identifier: Apache-2.0
// The whole loop on a simulated rig.

#include "acquisition/session.h"

#include <gmock/gmock.h>

#include <set>

#include "acquisition/event_log_sqlite.h"
#include "acquisition/session_record.h"
#include "tests/core/temp_dir.h"
#include "tests/scenario/bench.h"

namespace gonio {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> KindsOf(const SessionRecord& session) {
  std::vector<std::string> kinds;
  for (const SessionEvent& event : session.events) kinds.push_back(event.kind);
  return kinds;
}

TEST(Session, MeasuresWhatThePlannerAsksForAndTellsIt) {
  Bench bench;
  ScriptedPlanner planner(FourPoses());
  const SessionSummary summary = bench.Run(planner);
  EXPECT_EQ(summary.outcome, SessionOutcome::kComplete);
  EXPECT_EQ(summary.reason, "end of script");
  ASSERT_EQ(summary.poses.size(), 4u);
  ASSERT_EQ(planner.observed.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const BrdfSample& sample = planner.observed[i];
    const Rgb truth = *bench.sample.Eval(sample.directions);
    EXPECT_TRUE(((sample.f_r - truth).abs() < 5 * sample.sigma).all()) << sample.f_r.transpose();
    EXPECT_LT(AngleBetween(sample.directions.wi, sample.directions.wo),
              2 * FourPoses()[i].theta_d + 1e-3);
  }
  EXPECT_EQ(summary.frames, bench.camera->captures);
  EXPECT_GT(summary.travel, Seconds::zero());
  EXPECT_GT(summary.duration, summary.travel + summary.exposing + summary.preparation);
}

TEST(Session, MovesNothingWhileExposing) {
  Bench bench;
  ScriptedPlanner planner(FourPoses());
  (void)bench.Run(planner);
  EXPECT_GE(bench.camera->captures, 4);
  EXPECT_EQ(bench.camera->captures_while_moving, 0);
}

TEST(Session, HasTheRawRecordOnDiskBeforeThePlannerLearnsOfIt) {
  const TempDir dir;
  Bench bench;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  ScriptedPlanner planner(FourPoses());
  planner.on_observe = [&](int observed) {
    // Another connection sees committed transactions only.
    sqlite::Database db(log.file(), SQLITE_OPEN_READONLY);
    sqlite::Statement row(db,
                          "SELECT max(pose), (SELECT count(*) FROM exposures e WHERE e.pose ="
                          " (SELECT max(pose) FROM poses)), (SELECT min(length(counts)) FROM"
                          " exposures), (SELECT count(*) FROM events WHERE kind = 'pose_measured')"
                          " FROM poses");
    ASSERT_TRUE(row.Step());
    EXPECT_EQ(row.Integer(0), observed);
    EXPECT_GE(row.Integer(1), 1);
    EXPECT_EQ(row.Integer(2), 2 * 3 * bench.rig.camera.width * bench.rig.camera.height);
    EXPECT_EQ(row.Integer(3), observed);
  };
  EXPECT_EQ(bench.Run(planner, &log).poses.size(), 4u);
}

TEST(Session, LogsEverythingInOrder) {
  const TempDir dir;
  Bench bench;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  ScriptedPlanner planner({Degrees(5, 20), OutOfReach(), Degrees(30, 40)});
  const SessionSummary summary = bench.Run(planner, &log);
  const SessionRecord session = ReadSession(dir / "s");
  EXPECT_THAT(KindsOf(session),
              ElementsAre("session_start", "prepared", "pose_measured", "pose_reduced",
                          "pose_rejected", "pose_measured", "pose_reduced", "session_end"));
  for (std::size_t i = 1; i < session.events.size(); ++i) {
    EXPECT_GE(session.events[i].time, session.events[i - 1].time);
  }
  ASSERT_TRUE(session.end.has_value());
  EXPECT_EQ(session.end->outcome, "complete");
  EXPECT_EQ(session.end->poses, 2);
  EXPECT_EQ(session.end->rejected, 1);
  EXPECT_EQ(session.end->duration, summary.duration);
  ASSERT_EQ(session.poses.size(), 2u);
  EXPECT_EQ(session.poses[0].predicted_error, 1.0);  // before the first pose
  EXPECT_EQ(session.poses[1].predicted_error, 0.5);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_TRUE((session.poses[i].samples.front().f_r == planner.observed[i].f_r).all());
    EXPECT_EQ(session.poses[i].samples.front().directions.wi, planner.observed[i].directions.wi);
  }
}

TEST(Session, RejectsAPoseOutOfReachAndGoesOn) {
  Bench bench;
  ScriptedPlanner planner({Degrees(5, 20), OutOfReach(), Degrees(30, 40)});
  const SessionSummary summary = bench.Run(planner);
  EXPECT_EQ(summary.outcome, SessionOutcome::kComplete);
  EXPECT_EQ(summary.poses.size(), 2u);
  EXPECT_EQ(summary.rejected, 1);
  EXPECT_THAT(planner.rejected, ElementsAre(1));
}

TEST(Session, GivesUpAfterTooManyRejectionsInARow) {
  Bench bench;
  ScriptedPlanner planner({Degrees(5, 20), OutOfReach(), OutOfReach(), Degrees(30, 40),
                           OutOfReach(), OutOfReach(), OutOfReach(), Degrees(10, 60)});
  bench.rig.failures.max_in_a_row = 3;
  const SessionSummary summary = bench.Run(planner);
  EXPECT_EQ(summary.outcome, SessionOutcome::kDeviceFault);
  EXPECT_THAT(summary.reason, HasSubstr("3 failures with no pose measured between"));
  EXPECT_EQ(summary.poses.size(), 2u);
  EXPECT_EQ(summary.rejected, 5);
}

TEST(Session, FinishesThePoseWhenTheUserStopsIt) {
  const TempDir dir;
  Bench bench;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  ScriptedPlanner planner(FourPoses());
  std::stop_source user;
  bench.camera->on_capture = [&](int) {
    if (planner.observed.size() == 1) user.request_stop();  // in the middle of the second pose
  };
  const SessionSummary summary = bench.Run(planner, &log, {}, {user.get_token(), {}});
  EXPECT_EQ(summary.outcome, SessionOutcome::kStopped);
  EXPECT_EQ(summary.reason, "stopped by the user");
  EXPECT_EQ(planner.observed.size(), 2u);
  const SessionRecord session = ReadSession(dir / "s");
  EXPECT_EQ(session.poses.size(), 2u);
  ASSERT_TRUE(session.end.has_value());
  EXPECT_EQ(session.end->outcome, "stopped");
}

TEST(Session, StopsTheArmsAtOnceWhenTheUserInsists) {
  const TempDir dir;
  Bench bench;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  ScriptedPlanner planner(FourPoses());
  std::stop_source user;
  bench.camera->on_capture = [&](int) {
    if (planner.observed.size() == 1) user.request_stop();
  };
  const SessionSummary summary = bench.Run(planner, &log, {}, {{}, user.get_token()});
  EXPECT_EQ(summary.outcome, SessionOutcome::kStopped);
  EXPECT_EQ(planner.observed.size(), 1u);
  EXPECT_FALSE(bench.AnythingMoves());
  EXPECT_EQ(ReadSession(dir / "s").poses.size(), 1u);
}

TEST(Session, EndsWithEveryArmAtRestWhenADeviceIsGone) {
  const TempDir dir;
  Bench bench;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  ScriptedPlanner planner(FourPoses());
  planner.on_observe = [&](int observed) {
    if (observed == 2) bench.axis(kCameraAzimuth).PullPlug();
  };
  const SessionSummary summary = bench.Run(planner, &log);
  EXPECT_EQ(summary.outcome, SessionOutcome::kDeviceFault);
  EXPECT_THAT(summary.reason, HasSubstr("camera_azimuth"));
  EXPECT_FALSE(bench.AnythingMoves());
  EXPECT_EQ(bench.lamp->level(), 0);
  const SessionRecord session = ReadSession(dir / "s");
  EXPECT_EQ(session.poses.size(), 2u);
  EXPECT_THAT(KindsOf(session), ElementsAre("session_start", "prepared", "pose_measured",
                                            "pose_reduced", "pose_measured", "pose_reduced",
                                            "error", "clean_up_failed", "session_end"));
  EXPECT_EQ(session.end->outcome, "device fault");
}

TEST(Session, TellsThePlannerNothingOnceTheLogFails) {
  const TempDir dir;
  Bench bench;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  ScriptedPlanner planner(FourPoses());
  std::optional<FileSizeLimit> full;
  planner.on_observe = [&](int observed) {
    if (observed == 2) full.emplace(std::filesystem::file_size(log.file().string() + "-wal"));
  };
  const SessionSummary summary = bench.Run(planner, &log);
  full.reset();
  EXPECT_EQ(summary.outcome, SessionOutcome::kStorageFailed);
  EXPECT_THAT(summary.reason, HasSubstr("session.sqlite: cannot write"));
  EXPECT_EQ(planner.observed.size(), 2u);
  EXPECT_EQ(summary.poses.size(), 2u);
  EXPECT_FALSE(bench.AnythingMoves());
  EXPECT_EQ(ReadSession(dir / "s").poses.size(), 2u);
}

TEST(Session, LeavesTheLightOffHoweverItEnds) {
  Bench bench;
  ScriptedPlanner planner(FourPoses());
  double level_while_measuring = 0;
  planner.on_observe = [&](int) { level_while_measuring = bench.lamp->level(); };
  (void)bench.Run(planner);
  EXPECT_GT(level_while_measuring, 0);
  EXPECT_EQ(bench.lamp->level(), 0);
}

TEST(Session, GivesTheSameSamplesWithAndWithoutALog) {
  const TempDir dir;
  Bench with(5);
  Bench without(5);
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  ScriptedPlanner a(FourPoses());
  ScriptedPlanner b(FourPoses());
  const SessionSummary logged = with.Run(a, &log);
  const SessionSummary unlogged = without.Run(b);
  ASSERT_EQ(a.observed.size(), b.observed.size());
  for (std::size_t i = 0; i < a.observed.size(); ++i) {
    EXPECT_TRUE((a.observed[i].f_r == b.observed[i].f_r).all());
    EXPECT_EQ(a.observed[i].directions.wo, b.observed[i].directions.wo);
  }
  EXPECT_EQ(logged.duration, unlogged.duration);
}

TEST(Session, ReportsProgressAfterEveryPose) {
  Bench bench;
  ScriptedPlanner planner({Degrees(5, 20), OutOfReach(), Degrees(30, 40)});
  std::vector<Progress> seen;
  (void)bench.Run(planner, nullptr, {}, {}, [&](const Progress& p) { seen.push_back(p); });
  ASSERT_EQ(seen.size(), 3u);
  EXPECT_EQ(seen[0].poses, 1);
  EXPECT_EQ(seen[1].rejected, 1);
  EXPECT_EQ(seen[2].poses, 2);
  EXPECT_EQ(seen[2].max_poses, 3);
  EXPECT_LT(seen[0].elapsed, seen[2].elapsed);
  EXPECT_EQ(seen[2].predicted_error, 1.0 / 3);
}

TEST(SessionOptions, AreCheckedAndTheDefaultsPass) {
  SessionOptions options;
  options.Check();
  options.max_reference_change = 0;
  EXPECT_THAT(MessageOf<ConfigError>([&] { options.Check(); }), HasSubstr("max_reference_change"));
}

}  // namespace
}  // namespace gonio
