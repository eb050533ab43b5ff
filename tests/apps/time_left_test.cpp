// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/time_left.h"

#include <gtest/gtest.h>

#include "sim/random.h"

namespace gonio {
namespace {

TEST(TimeLeft, KnowsNothingBeforeAStep) {
  TimeLeft left;
  EXPECT_FALSE(left.For(3));
  left.Show(0, Seconds(70));
  EXPECT_FALSE(left.For(3));
}

// Homing before the first step is no part of a step's length.
TEST(TimeLeft, OfEvenStepsIsTheirSum) {
  TimeLeft left;
  for (int n = 0; n <= 5; ++n) left.Show(n, Seconds(70 + 4 * n));
  const auto interval = left.For(10);
  ASSERT_TRUE(interval);
  EXPECT_DOUBLE_EQ(interval->expected.count(), 40);
  EXPECT_DOUBLE_EQ(interval->low.count(), 40);
  EXPECT_DOUBLE_EQ(interval->high.count(), 40);
}

// Example failure is an interval for a single step.
TEST(TimeLeft, ItsIntervalHoldsWhatComesNineteenTimesOutOfTwenty) {
  Random random(1, 0);
  constexpr int kTrials = 2000;
  constexpr int kDone = 20;
  constexpr int kLeft = 30;
  int held = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    TimeLeft left;
    Seconds now(0);
    left.Show(0, now);
    for (int n = 1; n <= kDone; ++n) left.Show(n, now += Seconds(2 + 6 * random.Uniform()));
    const auto interval = left.For(kLeft);
    const Seconds then = now;
    for (int n = 0; n < kLeft; ++n) now += Seconds(2 + 6 * random.Uniform());
    if (now - then >= interval->low && now - then <= interval->high) ++held;
  }
  EXPECT_NEAR(static_cast<double>(held) / kTrials, 0.95, 0.02);
}

TEST(TimeLeft, ARefusedStepBelongsToTheNext) {
  TimeLeft left;
  left.Show(0, Seconds(0));
  left.Show(1, Seconds(4));
  left.Show(1, Seconds(5));  // refused
  left.Show(2, Seconds(8));
  EXPECT_DOUBLE_EQ(left.For(1)->expected.count(), 4);
}

}  // namespace
}  // namespace gonio
