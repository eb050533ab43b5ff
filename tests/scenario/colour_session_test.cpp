// SPDX-License-Identifier: Apache-2.0
// Sessions with a mono camera and a light with colours.

#include <gmock/gmock.h>

#include <cmath>

#include "acquisition/event_log_sqlite.h"
#include "acquisition/rereduction.h"
#include "acquisition/session_check.h"
#include "acquisition/session_history.h"
#include "tests/acquisition/simulated_rig.h"
#include "tests/core/temp_dir.h"
#include "tests/scenario/bench.h"

namespace gonio {
namespace {

using testing::HasSubstr;

const AnalyticBrdf kPaint{"paint", {Lambert{Rgb(0.15, 0.4, 0.04)}, Ggx{.roughness = 0.25}}};

// Arms that end where they are sent, and a steady light: homing again changes nothing.
SimConfig Steady() {
  SimConfig truth = DefaultTruth();
  truth.repeatability = truth.encoder_resolution = truth.light_drift_per_hour = 0;
  return truth;
}

std::vector<HalfDiff> Poses(int count) {
  std::vector<HalfDiff> poses;
  for (int i = 0; i < count; ++i) {
    poses.push_back(Degrees(2 + 68.0 * i / count, 8 + 50.0 * (i % 7) / 7, 90));
  }
  return poses;
}

SessionSummary RunOn(SimulatedRig& rig, Planner& planner, EventLog* log,
                     const SessionSoFar* so_far = nullptr, int stop_after = 1000) {
  std::stop_source stop;
  return RunSession(
      {rig.rig, rig.devices, rig.clock, planner, log, nullptr, so_far, nullptr, rig.draw}, {},
      {stop.get_token(), {}}, [&](const Progress& progress) {
        if (progress.poses >= stop_after) stop.request_stop();
      });
}

struct ZScores {
  Rgb mean = Rgb::Zero();
  Rgb deviation = Rgb::Zero();
};

ZScores ZScoresOf(const SessionSummary& summary) {
  std::vector<Rgb> scores;
  for (const BrdfSample& sample : summary.Samples()) {
    scores.emplace_back((sample.f_r - *kPaint.Eval(sample.directions)) / sample.sigma);
  }
  ZScores z;
  const auto n = static_cast<double>(scores.size());
  for (const Rgb& one : scores) z.mean += one / n;
  for (const Rgb& one : scores) z.deviation += (one - z.mean).square() / (n - 1);
  z.deviation = z.deviation.sqrt();
  return z;
}

// Example failure is a channel that is reduced with another's responsivity, frames or exposure.
TEST(ColourSession, MeasuresEachChannelWithinItsSigma) {
  constexpr int kCount = 200;
  for (const RigConfig& config : {LedRig(), WheelRig()}) {
    SimulatedRig rig(kPaint, 5, config, Steady());
    ScriptedPlanner planner(Poses(kCount));
    const SessionSummary summary = RunOn(rig, planner, nullptr);
    ASSERT_EQ(summary.outcome, SessionOutcome::kComplete) << summary.reason;
    ASSERT_GT(summary.poses.size(), 0.8 * kCount);
    const ZScores z = ZScoresOf(summary);
    const auto n = static_cast<double>(summary.poses.size());
    for (int c = 0; c < kChannels; ++c) {
      EXPECT_NEAR(z.mean[c], 0, 4 / std::sqrt(n)) << kChannelNames[c];
      EXPECT_NEAR(z.deviation[c], 1, 4 / std::sqrt(2 * n)) << kChannelNames[c];
    }
    EXPECT_LT(summary.frames, 3.6 * n);
  }
}

class ColourNight : public testing::Test {
 protected:
  static constexpr int kCount = 6;

  SessionSummary Begin(const std::filesystem::path& dir, int stop_after) {
    SimulatedRig rig(kPaint, 1, WheelRig(), Steady());
    ScriptedPlanner planner(Poses(kCount));
    EventLog log = EventLog::Create(dir, SomeInfo());
    return RunOn(rig, planner, &log, nullptr, stop_after);
  }
  SessionSummary Continue(const std::filesystem::path& dir) {
    const SessionRecord record = ReadSession(dir);
    const SessionHistory history = HistoryOf(record);
    SimulatedRig rig(kPaint, 1, WheelRig(), Steady(), history.end);
    ScriptedPlanner planner(Poses(kCount));
    const Retraced retraced = Retrace(record, history, rig.rig, planner);
    EXPECT_FALSE(retraced.first) << retraced.first->what;
    EventLog log = EventLog::Open(dir);
    return RunOn(rig, planner, &log, &retraced.so_far);
  }

  const TempDir dir_;
};

TEST_F(ColourNight, KeepsTheColourOfEachFrameAndReducesThemAgain) {
  Begin(dir_ / "s", 1000);
  const SessionRecord record = ReadSession(dir_ / "s");
  SessionFrames frames(dir_ / "s");
  const Calibrations none;
  const RigConfig rig = WheelRig();
  Rereduction rereduction(dir_ / "s", rig, none, {});
  ASSERT_EQ(record.poses.size(), static_cast<std::size_t>(kCount));
  for (const MeasuredPose& pose : record.poses) {
    std::array<int, 3> lit{};
    for (const Exposure& e : frames.Of(pose.pose)) {
      ASSERT_TRUE(e.colour);
      ++lit[static_cast<std::size_t>(*e.colour)];
    }
    for (const int n : lit) EXPECT_GE(n, 1);
    const auto again = rereduction.Of(pose);
    ASSERT_TRUE(again.ok());
    EXPECT_TRUE((again->front().sample.f_r == pose.samples.front().f_r).all());
    EXPECT_TRUE((again->front().sample.sigma == pose.samples.front().sigma).all());
  }
  EXPECT_TRUE(FindDamage(dir_ / "s").empty());
  ASSERT_EQ(RescueSession(dir_ / "s", dir_ / "rescued").poses, kCount);
  EXPECT_EQ(SessionFrames(dir_ / "rescued").Of(2).front().colour, frames.Of(2).front().colour);
}

// Example failure is a gain of red that is made of all colours' frames.
TEST_F(ColourNight, VisitsItsReferenceInEachColour) {
  RigConfig config = LedRig();
  config.drift.every_poses = 3;
  config.drift.frames = 2;
  SimulatedRig rig(kPaint, 1, config, Steady());
  ScriptedPlanner planner(Poses(kCount));
  {
    EventLog log = EventLog::Create(dir_ / "s", SomeInfo());
    const SessionSummary summary = RunOn(rig, planner, &log);
    ASSERT_EQ(summary.outcome, SessionOutcome::kComplete) << summary.reason;
    EXPECT_EQ(summary.reference_visits, 2);
    EXPECT_TRUE(((summary.gain.value - 1).abs() < 4 * summary.gain.sigma).all());
  }
  const SessionRecord record = ReadSession(dir_ / "s");
  int visits = 0;
  for (const SessionEvent& event : record.events) {
    if (event.kind != "reference") continue;
    ++visits;
    for (const char* colour : {"red", "green", "blue"}) {
      EXPECT_THAT(event.body, HasSubstr(std::string("\"colour\":\"") + colour + "\""));
    }
  }
  EXPECT_EQ(visits, 2);
  const Calibrations none;
  Rereduction rereduction(dir_ / "s", config, none, HistoryOf(record).visits);
  for (const MeasuredPose& pose : record.poses) {
    EXPECT_TRUE((rereduction.Of(pose)->front().sample.f_r == pose.samples.front().f_r).all());
  }
}

// Example failure is a resume that begins with red where the wheel stood at blue, or has forgotten
// how bright each colour was: other frames, other samples.
TEST_F(ColourNight, PausedAfterEveryPoseItIsTheSameSession) {
  const SessionSummary whole = Begin(dir_ / "whole", 1000);
  for (int n = 1; n < kCount; ++n) {
    const std::filesystem::path dir = dir_ / std::to_string(n);
    Begin(dir, n);
    const SessionSummary continued = Continue(dir);
    ASSERT_EQ(continued.poses.size(), whole.poses.size()) << continued.reason;
    EXPECT_EQ(continued.frames, whole.frames);
    EXPECT_NEAR(continued.exposing.count(), whole.exposing.count(), 1e-9);
    for (std::size_t i = 0; i < whole.poses.size(); ++i) {
      const BrdfSample& a = whole.poses[i].samples.front();
      const BrdfSample& b = continued.poses[i].samples.front();
      EXPECT_TRUE((a.f_r == b.f_r).all() && (a.sigma == b.sigma).all()) << n << ": pose " << i + 1;
    }
  }
}

// What the third format did not have is taken away. Example failure is a night of before that
// cannot be gone on with.
TEST(ColourSession, AnOlderSessionIsReadAndGoneOnWith) {
  const TempDir dir;
  {
    SteadyBench bench;
    EventLog log = EventLog::Create(dir / "s", SomeInfo());
    ScriptedPlanner planner(FourPoses());
    std::stop_source stop;
    bench.Run(planner, &log, {}, {stop.get_token(), {}}, [&](const Progress& progress) {
      if (progress.poses == 2) stop.request_stop();
    });
  }
  {
    sqlite::Database db(dir / "s" / kSessionFile, SQLITE_OPEN_READWRITE);
    db.Execute("ALTER TABLE exposures DROP COLUMN colour; PRAGMA user_version = 3");
  }
  const SessionRecord before = ReadSession(dir / "s");
  ASSERT_EQ(before.poses.size(), 2u);
  EXPECT_FALSE(SessionFrames(dir / "s").Of(1).front().colour);
  EXPECT_TRUE(FindDamage(dir / "s").empty());
  EXPECT_EQ(RescueSession(dir / "s", dir / "rescued").poses, 2);
  EXPECT_FALSE(SessionFrames(dir / "rescued").Of(2).front().colour);

  const SessionHistory history = HistoryOf(before);
  SteadyBench bench(history.end);
  ScriptedPlanner planner(FourPoses());
  const Retraced retraced = Retrace(before, history, bench.rig, planner);
  ASSERT_FALSE(retraced.first);
  {
    EventLog log = EventLog::Open(dir / "s");
    const SessionSummary summary = RunSession(
        {bench.rig, bench.devices, bench.clock, planner, &log, nullptr, &retraced.so_far}, {});
    EXPECT_EQ(summary.poses.size(), 4u) << summary.reason;
  }
  EXPECT_EQ(ReadSession(dir / "s").poses.size(), 4u);
  EXPECT_FALSE(SessionFrames(dir / "s").Of(1).front().colour);
  EXPECT_FALSE(SessionFrames(dir / "s").Of(4).front().colour);
  EXPECT_TRUE(FindDamage(dir / "s").empty());
  // The column stands at another place than in a new session.
  EXPECT_EQ(RescueSession(dir / "s", dir / "again").poses, 4);
  EXPECT_EQ(SessionFrames(dir / "again").Of(4).front().frame.counts,
            SessionFrames(dir / "s").Of(4).front().frame.counts);
}

}  // namespace
}  // namespace gonio
