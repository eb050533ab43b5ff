// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_motor.h"

#include <gtest/gtest.h>

namespace gonio {
namespace {

// 2 rad/s, 4 rad/s^2: ramps of 0.5 s and 0.5 rad.
class SimMotorTest : public testing::Test {
 protected:
  ManualClock clock_;
  SimMotor motor_{1, 2, 4, clock_};
};

TEST_F(SimMotorTest, RestsUntilStarted) {
  EXPECT_FALSE(motor_.Moving());
  EXPECT_EQ(motor_.Position(), 1);
}

TEST_F(SimMotorTest, LongMoveIsATrapezoid) {
  motor_.Start(11);
  EXPECT_DOUBLE_EQ(motor_.Remaining().count(), 5.5);  // d / w + w / a
  EXPECT_DOUBLE_EQ(motor_.PositionAt(Seconds(0.5)), 1.5);
  EXPECT_DOUBLE_EQ(motor_.PositionAt(Seconds(1.5)), 3.5);
  EXPECT_DOUBLE_EQ(motor_.PositionAt(Seconds(5.25)), 11 - 0.125);
  clock_.SleepFor(Seconds(5.5));
  EXPECT_FALSE(motor_.Moving());
  EXPECT_EQ(motor_.Position(), 11);
}

TEST_F(SimMotorTest, ShortMoveIsATriangleAndWorksBackwards) {
  motor_.Start(0.75);
  EXPECT_DOUBLE_EQ(motor_.Remaining().count(), 0.5);  // 2 sqrt(d / a)
  EXPECT_DOUBLE_EQ(motor_.PositionAt(Seconds(0.25)), 0.875);
  EXPECT_EQ(motor_.PositionAt(Seconds(9)), 0.75);
}

TEST_F(SimMotorTest, MoveToWhereItStandsTakesNoTime) {
  motor_.Start(1);
  EXPECT_FALSE(motor_.Moving());
  EXPECT_EQ(motor_.Position(), 1);
}

TEST_F(SimMotorTest, OverheadFollowsEveryMoveButNoneToWhereItStands) {
  SimMotor motor(1, 2, 4, clock_, Seconds(27));
  motor.Start(1);
  EXPECT_FALSE(motor.Moving());
  motor.Start(1.25);
  EXPECT_DOUBLE_EQ(motor.Remaining().count(), 27.5);
  EXPECT_EQ(motor.PositionAt(Seconds(1)), 1.25);
  EXPECT_TRUE(motor.MovingBetween(Seconds(27), Seconds(28)));
}

TEST_F(SimMotorTest, StopFreezesItMidway) {
  motor_.Start(11);
  clock_.SleepFor(Seconds(1.5));
  motor_.Stop();
  EXPECT_FALSE(motor_.Moving());
  clock_.SleepFor(Seconds(10));
  EXPECT_DOUBLE_EQ(motor_.Position(), 3.5);
}

TEST_F(SimMotorTest, NeverExceedsSpeedOrAcceleration) {
  motor_.Start(4);
  const double dt = 1e-3;
  double before = 1;
  double speed_before = 0;
  for (double t = dt; t < 3; t += dt) {
    const double position = motor_.PositionAt(Seconds(t));
    const double speed = (position - before) / dt;
    EXPECT_GE(speed, -1e-9);
    EXPECT_LE(speed, 2 + 1e-9);
    EXPECT_LE(std::abs(speed - speed_before) / dt, 4 + 1e-6);
    before = position;
    speed_before = speed;
  }
}

TEST_F(SimMotorTest, KnowsWhenItMoved) {
  clock_.SleepFor(Seconds(1));
  motor_.Start(1.25);  // until 1.5 s
  EXPECT_FALSE(motor_.MovingBetween(Seconds(0), Seconds(1)));
  EXPECT_TRUE(motor_.MovingBetween(Seconds(0), Seconds(1.1)));
  EXPECT_TRUE(motor_.MovingBetween(Seconds(1.4), Seconds(2)));
  EXPECT_FALSE(motor_.MovingBetween(Seconds(1.5), Seconds(2)));
}

}  // namespace
}  // namespace gonio
