// SPDX-License-Identifier: Apache-2.0
#include "drivers/filter_wheel_light.h"

#include <gmock/gmock.h>

#include "core/units.h"
#include "sim/sim_axis.h"
#include "sim/sim_light.h"

namespace gonio {
namespace {

using testing::HasSubstr;

constexpr std::array<double, 3> kPositions = {RadFromDeg(10), RadFromDeg(130), RadFromDeg(250)};

// A wheel that ends `repeatability` off its places.
struct Wheel {
  explicit Wheel(double repeatability = 0, double approach = 0) {
    AxisLimits limits{.min_position = RadFromDeg(-5),
                      .max_position = RadFromDeg(355),
                      .max_speed = RadFromDeg(90),
                      .acceleration = RadFromDeg(180),
                      .position_tolerance = RadFromDeg(0.1)};
    limits.approach = approach;
    motor = std::make_shared<SimMotor>(1, limits.max_speed, limits.acceleration, clock);
    SimAxisOptions options;
    options.repeatability = repeatability;
    auto made =
        std::make_unique<SimAxis>("filter_wheel", limits, options, motor, clock, Random(1, 0));
    axis = made.get();
    light = std::make_unique<FilterWheelLight>(
        std::make_unique<SimLight>("lamp", std::make_shared<SimLamp>(0)), std::move(made),
        FilterWheelSettings{.positions = kPositions, .retries = 2});
  }

  ManualClock clock;
  std::shared_ptr<SimMotor> motor;
  SimAxis* axis = nullptr;
  std::unique_ptr<FilterWheelLight> light;
};

TEST(FilterWheelLight, HomesOnceAndStandsStillAtTheFilter) {
  Wheel wheel;
  ASSERT_FALSE(wheel.axis->State()->homed);
  ASSERT_TRUE(wheel.light->Select(LightColour::kBlue, {}).ok());
  EXPECT_TRUE(wheel.axis->State()->homed);
  EXPECT_FALSE(wheel.motor->Moving());
  EXPECT_NEAR(wheel.motor->Position(), kPositions[2], 1e-9);
  const Seconds before = wheel.clock.Now();
  ASSERT_TRUE(wheel.light->Select(LightColour::kBlue, {}).ok());
  EXPECT_EQ(wheel.clock.Now(), before) << "it is there already";
  // 240 degrees at 90 a second, and half a second to brake and start.
  ASSERT_TRUE(wheel.light->Select(LightColour::kRed, {}).ok());
  EXPECT_NEAR((wheel.clock.Now() - before).count(), 240.0 / 90 + 0.5, 1e-6);
  EXPECT_THAT(wheel.light->identity(), HasSubstr("red at 10, green at 130, blue at 250 deg"));
}

// Example failure is a filter whose edge is in the light.
TEST(FilterWheelLight, TurnsAgainWhereItMissedAndSaysWhenItAlwaysDoes) {
  Wheel sometimes(RadFromDeg(0.12));
  for (int i = 0; i < 20; ++i) {
    const LightColour colour = kLightColours[i % 3];
    const auto selected = sometimes.light->Select(colour, {});
    if (!selected) continue;
    EXPECT_NEAR(sometimes.motor->Position(), kPositions[static_cast<std::size_t>(colour)],
                RadFromDeg(0.1) + 1e-9);
  }
  Wheel always(RadFromDeg(20));
  const auto selected = always.light->Select(LightColour::kGreen, {});
  ASSERT_FALSE(selected.ok());
  EXPECT_EQ(selected.error().code, ErrorCode::kRefused);
  EXPECT_THAT(selected.error().message, HasSubstr("filter_wheel: stands at"));
  EXPECT_THAT(selected.error().message, HasSubstr("after 3 turns to 130.0000 deg, tolerance 0.1"));
}

TEST(FilterWheelLight, ComesFromTheSideOfItsApproach) {
  Wheel wheel(0, RadFromDeg(3));
  ASSERT_TRUE(wheel.light->Select(LightColour::kBlue, {}).ok());
  const Seconds before = wheel.clock.Now();
  ASSERT_TRUE(wheel.light->Select(LightColour::kGreen, {}).ok());
  EXPECT_NEAR(wheel.motor->Position(), kPositions[1], 1e-9);
  // Backwards, so by way of a turning point: longer than the way straight there.
  EXPECT_GT((wheel.clock.Now() - before).count(), 120.0 / 90 + 0.5 + 0.1);
}

TEST(FilterWheelLight, GivesNothingWhileItIsOffOrNotAtAFilter) {
  Wheel wheel;
  ASSERT_TRUE(wheel.light->SetLevel(1).ok());
  EXPECT_EQ(*wheel.light->Selected(), std::nullopt) << "not homed";
  ASSERT_TRUE(wheel.light->Select(LightColour::kRed, {}).ok());
  EXPECT_EQ(*wheel.light->Selected(), LightColour::kRed);
  ASSERT_TRUE(wheel.axis->StartMove(RadFromDeg(60)).ok());
  EXPECT_EQ(*wheel.light->Selected(), std::nullopt) << "moving";
  ASSERT_TRUE(wheel.axis->WaitUntilStill(Seconds(60), {}).ok());
  EXPECT_EQ(*wheel.light->Selected(), std::nullopt) << "between two filters";
  ASSERT_TRUE(wheel.light->Select(LightColour::kRed, {}).ok());
  ASSERT_TRUE(wheel.light->SetLevel(0).ok());
  EXPECT_EQ(*wheel.light->Selected(), std::nullopt) << "off";
  wheel.axis->PullPlug();
  EXPECT_EQ(wheel.light->Select(LightColour::kBlue, {}).error().code, ErrorCode::kDisconnected);
}

TEST(FilterWheelLight, IsCancelled) {
  Wheel wheel;
  ASSERT_TRUE(wheel.light->Select(LightColour::kRed, {}).ok());
  std::stop_source stop;
  stop.request_stop();
  const auto selected = wheel.light->Select(LightColour::kBlue, stop.get_token());
  ASSERT_FALSE(selected.ok());
  EXPECT_EQ(selected.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace gonio
