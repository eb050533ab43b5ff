// SPDX-License-Identifier: Apache-2.0
// Sessions of an instrument whose responsivity drifts, which its monitor does not see.

#include <gmock/gmock.h>

#include "acquisition/event_log_sqlite.h"
#include "tests/acquisition/simulated_rig.h"
#include "tests/core/temp_dir.h"
#include "tests/scenario/bench.h"

namespace gonio {
namespace {

constexpr double kAlbedo = 0.3;  // 1/sr

SimConfig Drifting(double per_hour) {
  SimConfig truth = DefaultTruth();
  truth.responsivity_drift_per_hour = per_hour;
  return truth;
}

std::vector<HalfDiff> ManyPoses(int n) {
  std::vector<HalfDiff> poses;
  for (int i = 0; i < n; ++i) poses.push_back(Degrees(5 + 5 * (i % 7), 15 + 10 * (i % 4)));
  return poses;
}

SessionSummary RunDrifting(double per_hour, const DriftPolicy& policy, int poses,
                           std::uint64_t seed = 1, EventLog* log = nullptr) {
  const FlatBrdf sample(Rgb::Constant(kAlbedo));
  RigConfig config = DefaultRig();
  config.drift = policy;
  SimulatedRig rig(sample, seed, config, Drifting(per_hour));
  ScriptedPlanner planner(ManyPoses(poses));
  return RunSession({rig.rig, rig.devices, rig.clock, planner, log}, {});
}

DriftPolicy Every(int poses) {
  DriftPolicy policy;
  policy.every_poses = poses;
  return policy;
}

// Relative error of the mean of the last `n` poses.
double LateError(const SessionSummary& summary, int n) {
  double sum = 0;
  for (auto pose = summary.poses.end() - n; pose != summary.poses.end(); ++pose) {
    sum += pose->samples.front().f_r.mean() / n;
  }
  return sum / kAlbedo - 1;
}

// Two hours at 5 % an hour. Example failure: a gain that is multiplied where it should divide.
TEST(DriftSession, TakesOffWhatTheMonitorDoesNotSee) {
  constexpr double kSlope = -0.05;
  constexpr int kPoses = 2400;
  double before = 0, after = 0, squares = 0;
  constexpr int kSeeds = 4;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const SessionSummary with = RunDrifting(kSlope, Every(100), kPoses, seed);
    const SessionSummary without = RunDrifting(kSlope, {}, kPoses, seed);
    ASSERT_EQ(with.outcome, SessionOutcome::kComplete) << with.reason;
    EXPECT_EQ(with.poses.size(), static_cast<std::size_t>(kPoses));
    EXPECT_EQ(with.reference_visits, kPoses / 100);
    EXPECT_EQ(without.reference_visits, 0);
    before += LateError(without, 100) / kSeeds;
    after += LateError(with, 100) / kSeeds;
    // The stated gain at the end against the planted one.
    const double planted = SlowDrift(kSlope, with.duration);
    for (int c = 0; c < kChannels; ++c) {
      const double z = (with.gain.value[c] - planted) / with.gain.sigma[c];
      EXPECT_LT(with.gain.sigma[c], 0.012);
      squares += z * z / (kSeeds * kChannels);
    }
  }
  EXPECT_LT(before, -0.05);
  EXPECT_LT(std::abs(after), 0.006);
  EXPECT_LT(std::sqrt(squares), 1.5);
}

// Of no drift at all no more is made than the noise of the visits.
TEST(DriftSession, HarmsNothingWhereNothingDrifts) {
  const SessionSummary with = RunDrifting(0, Every(15), 120);
  const SessionSummary without = RunDrifting(0, {}, 120);
  EXPECT_LT(std::abs(LateError(with, 60) - LateError(without, 60)), 3 * with.gain.sigma[0]);
  EXPECT_LT(with.gain.sigma[0], 0.006);
}

int Count(sqlite::Database& db, const char* sql) {
  sqlite::Statement row(db, sql);
  return row.Step() ? static_cast<int>(row.Integer(0)) : -1;
}

// Visits are events and nothing else: no pose, no sample. Example failure: a visit that counts as a
// pose, so that the fit has one direction a hundred times.
TEST(DriftSession, LogsItsVisits) {
  const TempDir dir;
  {
    EventLog log = EventLog::Create(dir.path() / "session", SomeInfo());
    RunDrifting(-0.1, Every(10), 40, 1, &log);
  }
  sqlite::Database db(dir.path() / "session" / kSessionFile, SQLITE_OPEN_READONLY);
  EXPECT_EQ(Count(db, "SELECT count(*) FROM poses"), 40);
  EXPECT_EQ(Count(db, "SELECT count(*) FROM samples"), 40);
  EXPECT_EQ(Count(db, "SELECT count(*) FROM events WHERE kind = 'reference'"), 4);
  EXPECT_EQ(Count(db,
                  "SELECT count(*) FROM events WHERE kind = 'reference' AND json_extract(body, "
                  "'$.ratio[0]') > 0.9 AND json_extract(body, '$.ratio_sigma[0]') > 0.001 AND "
                  "json_extract(body, '$.frames[5].mean_counts[2]') > 20"),
            4);
  // The first pose comes before the first visit; all after it have the term.
  EXPECT_EQ(Count(db,
                  "SELECT count(*) FROM events WHERE kind = 'pose_reduced' AND json_extract(body, "
                  "'$.sigma_per_sr[0].drift[0]') > 0"),
            39);
}

TEST(DriftSession, VisitsTheNamedPoseBeforeAnythingElse) {
  DriftPolicy policy;
  policy.every = Seconds(120);
  policy.pose = Degrees(0, 25);
  const SessionSummary summary = RunDrifting(0, policy, 60);
  EXPECT_GE(summary.reference_visits, 2);
  EXPECT_NEAR(summary.reference_visits, summary.duration.count() / 130, 2);
}

TEST(DriftSession, StopsOrWarnsAtTooMuch) {
  DriftPolicy policy = Every(20);
  policy.max_change = 0.01;
  const SessionSummary warned = RunDrifting(-0.2, policy, 240);
  EXPECT_EQ(warned.outcome, SessionOutcome::kComplete);
  ASSERT_FALSE(warned.warnings.empty());
  EXPECT_THAT(warned.warnings.front(), testing::HasSubstr("of the reference has changed by -"));
  policy.stop = true;
  const SessionSummary stopped = RunDrifting(-0.2, policy, 240);
  EXPECT_EQ(stopped.outcome, SessionOutcome::kDeviceFault);
  EXPECT_LT(stopped.poses.size(), 240u);
  EXPECT_THAT(stopped.reason, testing::HasSubstr("drift.max_change_percent is 1"));
}

TEST(DriftSession, EndsWhereTheReferenceIsOutOfReach) {
  DriftPolicy policy = Every(20);
  policy.pose = OutOfReach();
  const SessionSummary summary = RunDrifting(0, policy, 5);
  EXPECT_EQ(summary.outcome, SessionOutcome::kDeviceFault);
  EXPECT_TRUE(summary.poses.empty());
  EXPECT_THAT(summary.reason, testing::StartsWith("reference: "));
}

}  // namespace
}  // namespace gonio
