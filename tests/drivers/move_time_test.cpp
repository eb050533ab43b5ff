// SPDX-License-Identifier: Apache-2.0
#include "drivers/move_time.h"

#include <gtest/gtest.h>

namespace gonio {
namespace {

AxisLimits FromBelow() {
  return {.min_position = -1,
          .max_position = 2,
          .max_speed = 2,
          .acceleration = 4,
          .position_tolerance = 1e-3,
          .approach = 0.25};
}

TEST(TrapezoidTime, FollowsTheClosedForms) {
  EXPECT_EQ(TrapezoidTime(0, 2, 4).count(), 0);
  EXPECT_DOUBLE_EQ(TrapezoidTime(0.25, 2, 4).count(), 0.5);  // triangle: 2 sqrt(d / a)
  EXPECT_DOUBLE_EQ(TrapezoidTime(1, 2, 4).count(), 1);       // both forms meet
  EXPECT_DOUBLE_EQ(TrapezoidTime(10, 2, 4).count(), 5.5);    // d / w + w / a
}

TEST(TurningPoint, MakesMovesEndInOneDirection) {
  AxisLimits limits = FromBelow();
  EXPECT_EQ(TurningPoint(1, 0.5, limits), 0.25);          // from above
  EXPECT_EQ(TurningPoint(0.4, 0.5, limits), 0.25);        // not far enough below
  EXPECT_EQ(TurningPoint(0, 0.5, limits), std::nullopt);  // from below
  EXPECT_EQ(TurningPoint(0.5, 0.5, limits), 0.25);
  limits.approach = -0.25;
  EXPECT_EQ(TurningPoint(1, 0.5, limits), std::nullopt);
  EXPECT_EQ(TurningPoint(0, 0.5, limits), 0.75);
  limits.approach = 0;
  EXPECT_EQ(TurningPoint(1, 0.5, limits), std::nullopt);
}

TEST(MoveTime, CountsTheTurn) {
  AxisLimits limits = FromBelow();
  EXPECT_DOUBLE_EQ(MoveTime(10, limits).count(), 5.5);
  EXPECT_DOUBLE_EQ(MoveTime(-9.75, limits).count(), 5.5 + 0.5);
  limits.move_overhead = Seconds(3);
  EXPECT_DOUBLE_EQ(MoveTime(-9.75, limits).count(), 5.5 + 0.5 + 2 * 3);
  EXPECT_EQ(MoveTime(5e-4, limits).count(), 0);
}

TEST(TargetLimits, LeaveRoomForTheTurn) {
  AxisLimits limits = FromBelow();
  EXPECT_EQ(TargetLimits(limits).min_position, -0.75);
  EXPECT_EQ(TargetLimits(limits).max_position, 2);
  limits.approach = -0.25;
  EXPECT_EQ(TargetLimits(limits).min_position, -1);
  EXPECT_EQ(TargetLimits(limits).max_position, 1.75);
}

}  // namespace
}  // namespace gonio
