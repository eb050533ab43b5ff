// SPDX-License-Identifier: Apache-2.0
#include "acquisition/time_model/time_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/units.h"
#include "sim/random.h"
#include "sim/sim_motor.h"
#include "tests/core/temp_dir.h"
#include "tests/geometry/planted.h"

namespace gonio {
namespace {

// What the axes truly do; the rig file believes 20 deg/s, 40 deg/s2 and no overhead.
constexpr std::array<double, kAxes> kSpeeds{12, 25, 17, 9};
constexpr std::array<double, kAxes> kAccelerations{30, 50, 25, 60};
constexpr std::array<double, kAxes> kOverheads{0.1, 0.4, 0.2, 0.3};

RigConfig SlowRig() {
  RigConfig rig = BelievedRig();
  for (AxisLimits& axis : rig.axes) {
    axis.max_speed = RadFromDeg(20);
    axis.acceleration = RadFromDeg(40);
    axis.move_overhead = Seconds(0);
  }
  return rig;
}

// Moves of simulated motors, with so much scatter of the time that is logged [s].
std::vector<LoggedMove> Moves(int count, std::uint64_t seed, double scatter) {
  Random random(seed, 1);
  std::vector<LoggedMove> moves;
  for (int k = 0; k < count; ++k) {
    LoggedMove move;
    for (int i = 0; i < kAxes; ++i) {
      const double widest = i == kLightAzimuth || i == kCameraAzimuth ? 120 : 60;
      // Short ways as well as long ones.
      move.way[i] =
          RadFromDeg(widest * std::pow(random.Uniform(), 3) * (random.Uniform() < 0.5 ? -1 : 1));
      if (random.Uniform() < 0.4 || std::abs(move.way[i]) < 2e-3) move.way[i] = 0;
      if (move.way[i] == 0) continue;
      ManualClock clock;
      SimMotor motor(0, RadFromDeg(kSpeeds[i]), RadFromDeg(kAccelerations[i]), clock,
                     Seconds(kOverheads[i]));
      motor.Start(move.way[i]);
      move.time = std::max(move.time, motor.Remaining());
    }
    move.time += Seconds(scatter * random.Normal());
    moves.push_back(move);
  }
  return moves;
}

// Example failure is a model in which axes follow one another.
TEST(FitTimes, FindsThePlantedSpeeds) {
  LoggedTimes times;
  times.moves = Moves(120, 3, 0.01);
  const auto fit = FitTimes(SlowRig(), times);
  ASSERT_TRUE(fit) << fit.error().message;
  for (int i = 0; i < kAxes; ++i) {
    EXPECT_NEAR(fit->max_speed[i].value, RadFromDeg(kSpeeds[i]), 4 * fit->max_speed[i].sigma);
    EXPECT_NEAR(fit->acceleration[i].value, RadFromDeg(kAccelerations[i]),
                4 * fit->acceleration[i].sigma);
    EXPECT_NEAR(fit->move_overhead[i].value, kOverheads[i], 4 * fit->move_overhead[i].sigma);
    EXPECT_LT(fit->max_speed[i].relative(), 0.05) << kAxisNames[i];
    EXPECT_GT(fit->decided[i], 5);
  }
  EXPECT_GT(fit->believed_rms, 0.5);
  EXPECT_NEAR(fit->fitted_rms, 0.01, 0.003);
}

TEST(FitTimes, UncertaintiesAreRightOverSeeds) {
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    LoggedTimes times;
    times.moves = Moves(120, seed, 0.02);
    const auto fit = FitTimes(SlowRig(), times);
    ASSERT_TRUE(fit);
    for (int i = 0; i < kAxes; ++i) {
      sum +=
          std::pow((fit->max_speed[i].value - RadFromDeg(kSpeeds[i])) / fit->max_speed[i].sigma, 2);
      ++count;
    }
  }
  const double spread = std::sqrt(sum / count);
  RecordProperty("z_spread", std::to_string(spread));
  EXPECT_GT(spread, 0.8);
  EXPECT_LT(spread, 1.2);
}

// An axis that never moves keeps what the rig file says, and says how little is known of it.
TEST(FitTimes, AnAxisThatNeverDecidesStaysAsBelieved) {
  LoggedTimes times;
  times.moves = Moves(60, 4, 0.01);
  for (LoggedMove& move : times.moves) move.way[kCameraElevation] = 0;
  std::erase_if(times.moves, [](const LoggedMove& move) { return move.time > Seconds(4); });
  const auto fit = FitTimes(SlowRig(), times);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->decided[kCameraElevation], 0);
  EXPECT_NEAR(fit->max_speed[kCameraElevation].value, RadFromDeg(20), 1e-6);
  EXPECT_NEAR(fit->max_speed[kCameraElevation].relative(), 0.5, 1e-6);
}

TEST(FitTimes, TellsPosesFromFrames) {
  LoggedTimes times;
  times.moves = Moves(20, 5, 0);
  for (int i = 0; i < 20; ++i)
    times.poses.push_back({1 + i % 4, Seconds(0.3 + 0.05 * (1 + i % 4))});
  const auto fit = FitTimes(SlowRig(), times);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->pose_overhead.value, 0.3, 1e-6);
  EXPECT_NEAR(fit->frame_overhead.value, 0.05, 1e-6);
}

TEST(FitTimes, RefusesASessionWithoutMoves) {
  const auto fit = FitTimes(SlowRig(), {});
  ASSERT_FALSE(fit);
  EXPECT_EQ(fit.error().message,
            "the sessions have 0 moves whose beginning is known; 10 are needed");
}

// Example failure is a way that is counted from a pose which the arms had left for a refused one.
TEST(AddTimes, CountsOnlyMovesWhoseBeginningIsKnown) {
  SessionRecord session;
  for (int i = 0; i < 4; ++i) {
    MeasuredPose& pose = session.poses.emplace_back();
    pose.start = Seconds(10 * i);
    pose.move_time = Seconds(2);
    pose.exposed = Seconds(1);
    pose.frames = 2;
    pose.end = pose.start + Seconds(4);
    pose.commanded[kLightAzimuth] = pose.readback[kLightAzimuth] = 0.1 * i * i;
  }
  session.poses[3].move_retries = 1;
  session.events.push_back({1, Seconds(15), "pose_rejected", "{}"});
  RigConfig rig = SlowRig();
  rig.motion.settle = Seconds(0.5);
  rig.camera.readout = Seconds(0.1);
  LoggedTimes times;
  AddTimes(session, rig, times);
  ASSERT_EQ(times.moves.size(), 1u);
  EXPECT_NEAR(times.moves[0].way[kLightAzimuth], 0.1, 1e-12);
  ASSERT_EQ(times.poses.size(), 3u);
  EXPECT_NEAR(times.poses[0].spare.count(), 0.3, 1e-12);
  // Two changes of the light's colour are foreseen by the rig, and not to be counted again.
  rig.by_colour = true;
  rig.colour_settle = Seconds(0.05);
  LoggedTimes coloured;
  AddTimes(session, rig, coloured);
  EXPECT_NEAR(coloured.poses[0].spare.count(), 0.2, 1e-12);
}

TEST(ReadTimes, ReadsWhatWasWritten) {
  const TempDir dir;
  LoggedTimes times;
  times.moves = Moves(40, 6, 0.01);
  const auto fit = FitTimes(SlowRig(), times);
  ASSERT_TRUE(fit);
  WriteTimes(dir.path() / kTimeFile, *fit, kAxisNames, 1700000000);
  const TimeModel model = ReadTimes(dir.path() / kTimeFile, kAxisNames);
  for (int i = 0; i < kAxes; ++i) {
    EXPECT_NEAR(model.max_speed[i], fit->max_speed[i].value, 1e-8);
    EXPECT_NEAR(model.acceleration[i], fit->acceleration[i].value, 1e-8);
    EXPECT_NEAR(model.move_overhead[i].count(), fit->move_overhead[i].value, 1e-8);
  }
}

}  // namespace
}  // namespace gonio
