// SPDX-License-Identifier: Apache-2.0
#include "core/clock.h"

#include <gtest/gtest.h>

namespace gonio {
namespace {

TEST(ManualClock, StartsAtZeroAndStandsStill) {
  const ManualClock clock;
  EXPECT_EQ(clock.Now(), Seconds(0));
  EXPECT_EQ(clock.Now(), Seconds(0));
}

TEST(ManualClock, MovesByWhatIsSleptAndAddsUp) {
  ManualClock clock;
  clock.SleepFor(Seconds(1.5));
  clock.SleepFor(Seconds(0.25));
  EXPECT_EQ(clock.Now(), Seconds(1.75));
}

TEST(ManualClock, CountsNegativeDurationsAsZero) {
  ManualClock clock;
  clock.SleepFor(Seconds(-3));
  EXPECT_EQ(clock.Now(), Seconds(0));
}

TEST(ManualClock, DoesNotSleepOnceStopIsRequested) {
  ManualClock clock;
  std::stop_source stop;
  clock.SleepFor(Seconds(1), stop.get_token());
  stop.request_stop();
  clock.SleepFor(Seconds(1), stop.get_token());
  EXPECT_EQ(clock.Now(), Seconds(1));
}

}  // namespace
}  // namespace gonio
