// SPDX-License-Identifier: Apache-2.0
#include "core/clock.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

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

TEST(WatchedClock, LooksAroundWhileItSleeps) {
  WatchedClock clock(std::make_unique<ManualClock>());
  std::vector<double> looks;
  clock.Watch(Seconds(0.5), [&] {
    looks.push_back(clock.Now().count());
    clock.SleepFor(Seconds(0.25));  // who looks may have to wait, too
  });
  clock.SleepFor(Seconds(1.5));
  EXPECT_EQ(looks, (std::vector<double>{0.5, 1.25}));
  clock.Watch(Seconds(0.5), {});
  clock.SleepFor(Seconds(1));
  EXPECT_EQ(looks.size(), 2u);
}

// Example failure is a sleeper that is not woken by what was seen.
TEST(WatchedClock, EndsASleepThatSomebodyStops) {
  WatchedClock clock(std::make_unique<ManualClock>());
  std::stop_source stop;
  clock.Watch(Seconds(0.5), [&] { stop.request_stop(); });
  clock.SleepFor(Seconds(10), stop.get_token());
  EXPECT_EQ(clock.Now(), Seconds(0.5));
}

TEST(WatchedClock, LooksInItsOwnThreadOnly) {
  WatchedClock clock(std::make_unique<ManualClock>());
  int looks = 0;
  clock.Watch(Seconds(0.5), [&] { ++looks; });
  std::thread([&] { clock.SleepFor(Seconds(1)); }).join();
  EXPECT_EQ(looks, 0);
  clock.SleepFor(Seconds(0.5));
  EXPECT_EQ(looks, 1);
}

TEST(SystemClock, PassesByItself) {
  SystemClock clock;
  const Seconds before = clock.Now();
  clock.SleepFor(Seconds(1e-3));
  EXPECT_GE((clock.Now() - before).count(), 1e-3);
  clock.SleepFor(Seconds(-1));
}

// Example failure is a stop that waits for the end of the exposure.
TEST(SystemClock, WakesWhenAskedTo) {
  SystemClock clock;
  std::stop_source stop;
  std::thread other([&] { stop.request_stop(); });
  clock.SleepFor(Seconds(1000), stop.get_token());
  other.join();
  clock.SleepFor(Seconds(1000), stop.get_token());
  EXPECT_LT(clock.Now().count(), 500);
}

}  // namespace
}  // namespace gonio
