// SPDX-License-Identifier: Apache-2.0
// Sessions that go on in another process, played within one.

#include <gmock/gmock.h>

#include "acquisition/rereduction.h"
#include "acquisition/session_history.h"
#include "planner/plan.h"
#include "tests/core/temp_dir.h"
#include "tests/scenario/bench.h"

namespace gonio {
namespace {

using testing::HasSubstr;

constexpr int kPoses = 10;

// A rig that homing and time do not change.
class Night : public testing::Test {
 protected:
  static Plan ThePlan() {
    const std::string path = std::string(GONIO_SOURCE_DIR) + "/configs/plan-information.yaml";
    Plan plan = LoadPlan(path);
    plan.max_poses = kPoses;
    return plan;
  }

  static std::unique_ptr<Planner> ThePlanner(const Bench& bench) {
    const Kinematics kinematics(bench.rig);
    return MakePlanner(ThePlan(), {.reachable = [kinematics](const DirectionPair& pair) {
                         return kinematics.Reachable(pair);
                       }});
  }

  // Up to `stop_after` poses, or to the end.
  SessionSummary Begin(const std::filesystem::path& dir, int stop_after) {
    SteadyBench bench;
    bench.rig.drift.every_poses = visit_every_;
    const std::unique_ptr<Planner> planner = ThePlanner(bench);
    EventLog log = EventLog::Create(dir, SomeInfo());
    return Go(bench, *planner, log, nullptr, stop_after);
  }

  // Goes on with it; `rest`: as above.
  SessionSummary Continue(const std::filesystem::path& dir, int stop_after) {
    const SessionRecord record = ReadSession(dir);
    const SessionHistory history = HistoryOf(record);
    SteadyBench bench(history.end);
    bench.rig.drift.every_poses = visit_every_;
    const std::unique_ptr<Planner> planner = ThePlanner(bench);
    const Retraced retraced = Retrace(record, history, bench.rig, *planner);
    EXPECT_FALSE(retraced.first) << retraced.first->what;
    EventLog log = EventLog::Open(dir);
    EXPECT_TRUE(
        log.AppendResume(history.end, {.gonio_version = "0", .poses = 0, .changes = {}, .now = {}})
            .ok());
    return Go(bench, *planner, log, &retraced.so_far, stop_after);
  }

  static SessionSummary Go(Bench& bench, Planner& planner, EventLog& log,
                           const SessionSoFar* so_far, int stop_after) {
    std::stop_source stop;
    return RunSession({bench.rig, bench.devices, bench.clock, planner, &log, nullptr, so_far,
                       nullptr, bench.draw},
                      {}, {stop.get_token(), {}}, [&](const Progress& progress) {
                        if (progress.poses >= stop_after) stop.request_stop();
                      });
  }

  static void ExpectSame(const SessionSummary& a, const SessionSummary& b) {
    ASSERT_EQ(a.poses.size(), b.poses.size());
    for (std::size_t i = 0; i < a.poses.size(); ++i) {
      const BrdfSample& x = a.poses[i].samples.front();
      const BrdfSample& y = b.poses[i].samples.front();
      EXPECT_EQ(x.directions.wi, y.directions.wi) << "pose " << i + 1;
      EXPECT_TRUE((x.f_r == y.f_r).all() && (x.sigma == y.sigma).all()) << "pose " << i + 1;
      EXPECT_EQ(a.poses[i].predicted_error, b.poses[i].predicted_error);
    }
    EXPECT_EQ(a.reason, b.reason);
    EXPECT_EQ(a.frames, b.frames);
    EXPECT_EQ(a.rejected, b.rejected);
    EXPECT_EQ(a.predicted_error, b.predicted_error);
    EXPECT_NEAR(a.exposing.count(), b.exposing.count(), 1e-9);
  }

  const TempDir dir_;
  int visit_every_ = 0;  // poses from one visit to the reference to the next; 0: none
};

// Example failure is a resume that starts with the arms somewhere else, so that another of two
// equal solutions of the next pose is nearer.
TEST_F(Night, PausedAfterEveryPoseItIsTheSameSession) {
  const SessionSummary whole = Begin(dir_ / "whole", kPoses + 1);
  ASSERT_EQ(whole.poses.size(), static_cast<std::size_t>(kPoses));
  for (int n = 0; n < kPoses; ++n) {
    const std::filesystem::path dir = dir_ / std::to_string(n);
    Begin(dir, n);
    ExpectSame(whole, Continue(dir, kPoses + 1));
  }
}

TEST_F(Night, PausedAgainAndAgainItIsTheSameSession) {
  const SessionSummary whole = Begin(dir_ / "whole", kPoses + 1);
  Begin(dir_ / "s", 1);
  for (int n = 2; n < kPoses; ++n) Continue(dir_ / "s", n);
  ExpectSame(whole, Continue(dir_ / "s", kPoses + 1));
  const SessionRecord record = ReadSession(dir_ / "s");
  EXPECT_EQ(record.end->reason, "pose budget reached");
  EXPECT_EQ(record.end->poses, kPoses);
}

// Example failure is a resume that forgets the visits before it: the first after it is then another
// beginning, and samples jump.
TEST_F(Night, VisitsToTheReferenceGoOnAsWell) {
  visit_every_ = 3;
  const SessionSummary whole = Begin(dir_ / "whole", kPoses + 1);
  ASSERT_EQ(whole.reference_visits, 4);
  for (int n = 1; n < kPoses; ++n) {
    const std::filesystem::path dir = dir_ / std::to_string(n);
    Begin(dir, n);
    const SessionSummary continued = Continue(dir, kPoses + 1);
    EXPECT_EQ(continued.reference_visits, whole.reference_visits);
    ASSERT_EQ(continued.poses.size(), whole.poses.size());
    for (std::size_t i = 0; i < whole.poses.size(); ++i) {
      const Rgb& f_r = continued.poses[i].samples.front().f_r;
      // The gain is of the times of poses, which a resume moves on.
      EXPECT_TRUE((f_r / whole.poses[i].samples.front().f_r - 1).abs().maxCoeff() < 2e-3)
          << n << ": pose " << i + 1;
    }
  }
  SteadyBench bench;
  bench.rig.drift.every_poses = visit_every_;
  const Calibrations none;
  const SessionRecord record = ReadSession(dir_ / "5");
  Rereduction rereduction(dir_ / "5", bench.rig, none, HistoryOf(record).visits);
  for (const MeasuredPose& pose : record.poses) {
    EXPECT_TRUE((rereduction.Of(pose)->front().sample.f_r == pose.samples.front().f_r).all());
  }
}

TEST_F(Night, SaysWhereAPlannerDecidesOtherwise) {
  Begin(dir_ / "s", kPoses + 1);
  const SessionRecord record = ReadSession(dir_ / "s");
  SessionHistory history = HistoryOf(record);
  ASSERT_EQ(history.turns.size(), static_cast<std::size_t>(kPoses));
  SteadyBench bench;
  std::swap(history.turns[4].proposal, history.turns[5].proposal);
  const std::unique_ptr<Planner> planner = ThePlanner(bench);
  const Retraced retraced = Retrace(record, history, bench.rig, *planner);
  ASSERT_TRUE(retraced.first);
  EXPECT_EQ(retraced.first->turn, 4);
  EXPECT_THAT(retraced.first->what, HasSubstr("turn 5: the log has candidate"));
  EXPECT_EQ(retraced.so_far.summary.poses.size(), 4u);

  // Told of all the same, it does not ask for any of them again.
  const std::unique_ptr<Planner> other = ThePlanner(bench);
  const Kinematics kinematics(bench.rig);
  const Retraced learned = Retrace(
      record, history, bench.rig, *other,
      {.agree_from = kPoses,
       .learn = IndexIn(CandidatesOf(
           ThePlan(), [&](const DirectionPair& pair) { return kinematics.Reachable(pair); }))});
  EXPECT_FALSE(learned.first);
  EXPECT_EQ(learned.so_far.summary.poses.size(), static_cast<std::size_t>(kPoses));
  EXPECT_FALSE(other->Next());
  EXPECT_EQ(other->reason(), "pose budget reached");
}

TEST_F(Night, FramesGiveTheSamplesAgain) {
  const SessionSummary whole = Begin(dir_ / "s", kPoses + 1);
  SteadyBench bench;
  const Calibrations none;
  Rereduction rereduction(dir_ / "s", bench.rig, none, {});
  const SessionRecord record = ReadSession(dir_ / "s");
  for (std::size_t i = 0; i < record.poses.size(); ++i) {
    const auto again = rereduction.Of(record.poses[i]);
    ASSERT_TRUE(again.ok());
    EXPECT_TRUE((again->front().sample.f_r == whole.poses[i].samples.front().f_r).all());
    EXPECT_EQ(again->front().sample.directions.wo, whole.poses[i].samples.front().directions.wo);
  }
}

}  // namespace
}  // namespace gonio
