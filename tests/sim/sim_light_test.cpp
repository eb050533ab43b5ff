// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_light.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gonio {
namespace {

TEST(SimLamp, DriftsAtTheGivenRateAndStaysBounded) {
  SimLamp lamp(0.01);
  lamp.set_level(0.5);
  EXPECT_EQ(lamp.PowerAt(Seconds(0)), 0.5);
  EXPECT_NEAR(lamp.PowerAt(Seconds(360)) / 0.5 - 1, 0.001, 0.00001);
  for (double hours = 0; hours < 50; hours += 0.1) {
    EXPECT_NEAR(lamp.PowerAt(Seconds(hours * 3600)) / 0.5, 1, 0.0128);
  }
}

TEST(SimLamp, WithoutDriftIsConstant) {
  SimLamp lamp(0);
  lamp.set_level(1);
  EXPECT_EQ(lamp.PowerAt(Seconds(12345)), 1);
}

TEST(SimLamp, FlickersFromFrameToFrame) {
  SimLamp lamp(0, {.flicker = 0.01, .seed = 1});
  lamp.set_level(0.5);
  double sum = 0;
  double squares = 0;
  constexpr int kFrames = 4000;
  for (int i = 0; i < kFrames; ++i) {
    const double relative = lamp.PowerAt(Seconds(0.05 * i)) / 0.5 - 1;
    sum += relative;
    squares += relative * relative;
  }
  EXPECT_NEAR(sum / kFrames, 0, 0.001);
  EXPECT_NEAR(std::sqrt(squares / kFrames), 0.01, 0.0006);
  EXPECT_EQ(lamp.PowerAt(Seconds(7)), lamp.PowerAt(Seconds(7)));
}

TEST(SimLamp, Fails) {
  SimLamp lamp(0, {.fails_at = Seconds(60)});
  lamp.set_level(1);
  EXPECT_EQ(lamp.PowerAt(Seconds(59)), 1);
  EXPECT_EQ(lamp.PowerAt(Seconds(60)), 0);
  EXPECT_EQ(lamp.level(), 1);
}

TEST(SimMonitor, ReadsThePowerWithItsNoise) {
  ManualClock clock;
  auto lamp = std::make_shared<SimLamp>(0);
  lamp->set_level(0.5);
  SimMonitor monitor("monitor", lamp, 0.01, clock, Random(1, 1));
  constexpr int kReadings = 20000;
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < kReadings; ++i) {
    const double relative = *monitor.Read() / 0.5 - 1;
    sum += relative;
    squares += relative * relative;
  }
  EXPECT_NEAR(sum / kReadings, 0, 0.0004);
  EXPECT_NEAR(std::sqrt(squares / kReadings), 0.01, 0.0003);
}

TEST(SimMonitor, FollowsTheDriftExactlyWithoutNoise) {
  ManualClock clock;
  auto lamp = std::make_shared<SimLamp>(0.05);
  lamp->set_level(1);
  SimMonitor monitor("monitor", lamp, 0, clock, Random(1, 1));
  clock.SleepFor(Seconds(3600));
  EXPECT_EQ(*monitor.Read(), lamp->PowerAt(Seconds(3600)));
  EXPECT_GT(*monitor.Read(), 1.04);
}

}  // namespace
}  // namespace gonio
