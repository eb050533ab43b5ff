// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_axis.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/units.h"

namespace gonio {
namespace {

const AxisLimits kLimits = {.min_position = -2,
                            .max_position = 3,
                            .max_speed = 0.5,
                            .acceleration = 1,
                            .position_tolerance = 0.01};

struct Bench {
  explicit Bench(const SimAxisOptions& options = {}, const AxisLimits& limits = kLimits)
      : motor(std::make_shared<SimMotor>(0.7, limits.max_speed, limits.acceleration, clock)),
        axis("axis", limits, options, motor, clock, Random(1, 1)) {}

  void Home() { ASSERT_TRUE(axis.Home({}).ok()); }
  double MoveTo(double target) {
    EXPECT_TRUE(axis.StartMove(target).ok());
    EXPECT_TRUE(axis.WaitUntilStill(Seconds(100), {}).ok());
    return axis.State()->position;
  }

  ManualClock clock;
  std::shared_ptr<SimMotor> motor;
  SimAxis axis;
};

TEST(SimAxis, CountsFromWhereItWasSwitchedOnUntilHomed) {
  Bench bench;
  EXPECT_EQ(bench.axis.State()->position, 0);
  EXPECT_FALSE(bench.axis.State()->homed);
  bench.Home();
  EXPECT_TRUE(bench.axis.State()->homed);
  EXPECT_EQ(bench.axis.State()->position, 0);  // the reference mark
  EXPECT_EQ(bench.motor->Position(), 0);
}

TEST(SimAxis, HomingTakesFourTimesAsLongAsAMove) {
  Bench bench;
  bench.Home();
  EXPECT_DOUBLE_EQ(bench.clock.Now().count(), 0.7 / 0.125 + 0.125);
}

TEST(SimAxis, HomingGivesUpAfterItsLimit) {
  SimAxisOptions options;
  options.home_limit = Seconds(3);
  Bench bench(options);
  const auto homed = bench.axis.Home({});
  ASSERT_FALSE(homed.ok());
  EXPECT_EQ(homed.error().code, ErrorCode::kTimeout);
  EXPECT_EQ(homed.error().message, "axis: homing: not done after 3 s");
  EXPECT_FALSE(bench.axis.State()->homed);
}

TEST(SimAxis, MoveTakesTheTrapezoidsTime) {
  Bench bench;
  bench.Home();
  const Seconds before = bench.clock.Now();
  EXPECT_EQ(bench.MoveTo(2), 2);
  EXPECT_DOUBLE_EQ((bench.clock.Now() - before).count(), 2 / 0.5 + 0.5 / 1);
}

TEST(SimAxis, EncoderReadsTheTruthRounded) {
  SimAxisOptions options;
  options.encoder_resolution = 0.1;
  options.repeatability = 0.02;
  AxisLimits coarse = kLimits;
  coarse.position_tolerance = 0.2;
  Bench bench(options, coarse);
  bench.Home();
  for (double target = -1; target < 2; target += 0.13) {
    const double reading = bench.MoveTo(target);
    EXPECT_NEAR(reading, bench.motor->Position(), 0.05 + 1e-12);
    EXPECT_NEAR(std::remainder(reading, 0.1), 0, 1e-12);
  }
}

TEST(SimAxis, RepeatabilityIsTheStandardDeviationOfWhereMovesEnd) {
  SimAxisOptions options;
  options.repeatability = 0.001;
  Bench bench(options);
  bench.Home();
  double squares = 0;
  constexpr int kMoves = 4000;
  for (int i = 0; i < kMoves; ++i) {
    const double target = i % 2 == 0 ? 1 : -1;
    bench.MoveTo(target);
    squares += std::pow(bench.motor->Position() - target, 2);
  }
  EXPECT_NEAR(std::sqrt(squares / kMoves), 0.001, 0.00005);
}

TEST(SimAxis, LeavesTheMotorAloneWhenItReadsItsTarget) {
  SimAxisOptions options;
  options.encoder_resolution = 0.001;
  options.repeatability = 0.003;
  Bench bench(options);
  bench.Home();
  const double reading = bench.MoveTo(1);
  const double position = bench.motor->Position();
  EXPECT_EQ(bench.MoveTo(reading), reading);
  EXPECT_EQ(bench.motor->Position(), position);
}

TEST(SimAxis, AMissIsATimeoutThatSaysByHowMuch) {
  SimAxisOptions options;
  options.repeatability = 1;
  Bench bench(options);
  bench.Home();
  ASSERT_TRUE(bench.axis.StartMove(0.5).ok());
  const auto still = bench.axis.WaitUntilStill(Seconds(100), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().code, ErrorCode::kTimeout);
}

TEST(SimAxis, StopFromOutsideEndsTheMoveShort) {
  Bench bench;
  bench.Home();
  ASSERT_TRUE(bench.axis.StartMove(2).ok());
  bench.clock.SleepFor(Seconds(1));
  ASSERT_TRUE(bench.axis.Stop().ok());
  EXPECT_FALSE(bench.axis.State()->moving);
  EXPECT_EQ(bench.axis.WaitUntilStill(Seconds(100), {}).error().code, ErrorCode::kTimeout);
}

TEST(SimAxis, ForgetsItsPositionWhenItLosesPower) {
  Bench bench;
  bench.Home();
  bench.MoveTo(1);
  bench.axis.LosePower();
  EXPECT_FALSE(bench.axis.State()->homed);
  EXPECT_EQ(bench.axis.State()->position, 0);
  EXPECT_EQ(bench.axis.StartMove(1).error().code, ErrorCode::kRefused);
  bench.Home();
  EXPECT_EQ(bench.MoveTo(1), 1);
}

TEST(SimAxis, TimeoutLeavesItAtRestWhereItWas) {
  Bench bench;
  bench.Home();
  ASSERT_TRUE(bench.axis.StartMove(2).ok());
  const auto still = bench.axis.WaitUntilStill(Seconds(1), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().message, "axis: move: not done after 1 s");
  EXPECT_FALSE(bench.motor->Moving());
  EXPECT_DOUBLE_EQ(bench.motor->Position(), 0.375);
}

}  // namespace
}  // namespace gonio
