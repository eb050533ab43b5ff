// SPDX-License-Identifier: Apache-2.0
#include "drivers/grbl_legs.h"

#include <gmock/gmock.h>

namespace gonio::grbl {
namespace {

TEST(GrblLegs, OneAxisGoesStraightThere) {
  const auto legs = LegsOf({{.axis = 1, .from = -10, .to = -40, .speed = 20}});
  ASSERT_EQ(legs.size(), 1u);
  EXPECT_EQ(legs[0].target[1], -40);
  EXPECT_FALSE(legs[0].target[0]);
  EXPECT_DOUBLE_EQ(legs[0].feed, 1200);
}

// Example failure is one straight move, in which the axis that has the shorter way crawls.
TEST(GrblLegs, EachAxisKeepsItsSpeedUntilItIsThere) {
  const auto legs = LegsOf({{.axis = 0, .from = 0, .to = -30, .speed = 30},     // 1 s
                            {.axis = 1, .from = -100, .to = -20, .speed = 40},  // 2 s
                            {.axis = 2, .from = -50, .to = -50, .speed = 1}});  // is there
  ASSERT_EQ(legs.size(), 2u);
  EXPECT_EQ(legs[0].target[0], -30);
  EXPECT_DOUBLE_EQ(*legs[0].target[1], -60);
  EXPECT_FALSE(legs[0].target[2]);
  EXPECT_DOUBLE_EQ(legs[0].feed, 60 * 50);
  EXPECT_FALSE(legs[1].target[0]);
  EXPECT_EQ(legs[1].target[1], -20);
  EXPECT_DOUBLE_EQ(legs[1].feed, 60 * 40);
}

TEST(GrblLegs, EndsThatAreNearlyOneAreOneAndNobodyHurries) {
  const auto legs = LegsOf({{.axis = 0, .from = 0, .to = -30, .speed = 30},
                            {.axis = 1, .from = 0, .to = -31, .speed = 30}});
  ASSERT_EQ(legs.size(), 1u);
  EXPECT_EQ(legs[0].target[0], -30);
  EXPECT_EQ(legs[0].target[1], -31);
  EXPECT_LT(legs[0].feed, 60 * 30 * 1.4143);
}

TEST(GrblLegs, NoneWhereAllAreThere) {
  EXPECT_TRUE(LegsOf({}).empty());
  EXPECT_TRUE(LegsOf({{.axis = 0, .from = -1, .to = -1, .speed = 5}}).empty());
}

}  // namespace
}  // namespace gonio::grbl
