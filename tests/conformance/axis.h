// SPDX-License-Identifier: Apache-2.0
// The promises of drivers/axis.h, asked of any axis. Include in one .cpp per test program and
// instantiate:
//
//   INSTANTIATE_TEST_SUITE_P(Sim, AxisConformance, testing::Values(MakeSimAxisSubject));

#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <thread>

#include "drivers/axis.h"

namespace gonio {

// An axis that was just opened, and what a test may do to it.
struct AxisSubject {
  std::shared_ptr<Clock> clock;
  std::unique_ptr<Axis> axis;
  std::function<double()> shaft;    // true position [rad], also after the axis is gone
  std::function<void()> pull_plug;  // breaks the link
  // Of a real one nobody knows where it stands but itself, also after it was opened again; and
  // nobody pulls its plug. Those two are empty then.
  std::function<std::unique_ptr<Axis>()> open_again;
  double noise = 0;    // rad, of the position of an axis that stands
  std::string absent;  // why there is none, so that tests are skipped
};
using AxisFactory = std::function<AxisSubject()>;

class AxisConformance : public testing::TestWithParam<AxisFactory> {
 protected:
  void SetUp() override {
    subject_ = GetParam()();
    if (!subject_.absent.empty()) GTEST_SKIP() << subject_.absent;
  }

  Axis& axis() { return *subject_.axis; }
  void Home() {
    const auto homed = axis().Home({});
    ASSERT_TRUE(homed.ok()) << homed.error().message;
  }
  double Middle() { return (axis().limits().min_position + axis().limits().max_position) / 2; }
  double Shaft() {
    if (subject_.shaft) return subject_.shaft();
    if (!subject_.axis) subject_.axis = subject_.open_again();
    return axis().State()->position;
  }
  // Starts a move across a third of the range and lets it run a little. How long the
  // whole move should take goes to `expected`.
  void StartLongMove(Seconds* expected = nullptr) {
    const AxisLimits& limits = axis().limits();
    const double third = (limits.max_position - limits.min_position) / 3;
    const double from = Shaft();
    const auto started = axis().StartMove(from < Middle() ? from + third : from - third);
    ASSERT_TRUE(started.ok());
    if (expected != nullptr) *expected = *started;
    subject_.clock->SleepFor(Seconds(0.1));
  }
  // Whether the shaft turns within the next second.
  bool Turns() {
    const double before = Shaft();
    subject_.clock->SleepFor(Seconds(1));
    return std::abs(Shaft() - before) > subject_.noise;
  }

  AxisSubject subject_;
};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(AxisConformance);

// Promise 2. Example failure is an axis that moves by the zero it happened to be switched on with.
// First, since a real one that was homed stays so.
TEST_P(AxisConformance, RefusesToMoveBeforeItIsHomed) {
  if (axis().State()->homed) GTEST_SKIP() << "it is homed; switch it off and on";
  const auto started = axis().StartMove(Middle());
  ASSERT_FALSE(started.ok());
  EXPECT_EQ(started.error().code, ErrorCode::kRefused);
  EXPECT_FALSE(Turns());
}

// Promise 1. Example failure is an axis that reports its set-point, or one that calls a move done
// when the controller has accepted it.
TEST_P(AxisConformance, EndsWithinItsTolerance) {
  Home();
  const AxisLimits& limits = axis().limits();
  for (const double fraction : {0.0, 0.3, 0.301, 1.0, 0.5}) {
    const double target = std::lerp(limits.min_position, limits.max_position, fraction);
    ASSERT_TRUE(axis().StartMove(target).ok());
    ASSERT_TRUE(axis().WaitUntilStill(Seconds(600), {}).ok());
    const auto state = axis().State();
    ASSERT_TRUE(state.ok());
    EXPECT_FALSE(state->moving);
    EXPECT_NEAR(state->position, target, limits.position_tolerance);
    EXPECT_NEAR(Shaft(), target, limits.position_tolerance);
  }
}

// Promise 2. Example failure is a driver that leaves limits to the controller.
TEST_P(AxisConformance, RefusesTargetsOutsideItsLimitsAndNaN) {
  Home();
  const AxisLimits& limits = axis().limits();
  for (const double target :
       {limits.min_position - 1e-6, limits.max_position + 1e-6,
        std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const auto started = axis().StartMove(target);
    ASSERT_FALSE(started.ok()) << target;
    EXPECT_EQ(started.error().code, ErrorCode::kRefused);
    EXPECT_NE(started.error().message.find(axis().name()), std::string::npos);
    EXPECT_FALSE(Turns());
  }
}

// Promise 3. Example failure is a Stop() that waits for the lock which a move holds.
TEST_P(AxisConformance, StopsFromAnyThreadAnyNumberOfTimes) {
  EXPECT_TRUE(axis().Stop().ok());
  Home();
  StartLongMove();
  Result<void> first = Error{ErrorCode::kTimeout, "not called"};
  std::thread([&] { first = axis().Stop(); }).join();
  EXPECT_TRUE(first.ok());
  EXPECT_FALSE(axis().State()->moving);
  EXPECT_FALSE(Turns());
  EXPECT_TRUE(axis().Stop().ok());
}

// Promise 3. Example failure is an emergency stop that waits for the arm to slow down nicely.
TEST_P(AxisConformance, StopsInAnEmergency) {
  EXPECT_TRUE(axis().EmergencyStop().ok());
  Home();
  StartLongMove();
  Result<void> stopped = Error{ErrorCode::kTimeout, "not called"};
  std::thread([&] { stopped = axis().EmergencyStop(); }).join();
  EXPECT_TRUE(stopped.ok()) << stopped.error().message;
  EXPECT_FALSE(axis().State()->moving);
  EXPECT_FALSE(Turns());
}

// Promise 4. Example failure is a driver that reopens its port, and moves an axis that has lost
// its reference.
TEST_P(AxisConformance, StaysDisconnected) {
  if (!subject_.pull_plug) GTEST_SKIP() << "nobody pulls its plug";
  Home();
  subject_.pull_plug();
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(axis().State().error().code, ErrorCode::kDisconnected);
    EXPECT_EQ(axis().Home({}).error().code, ErrorCode::kDisconnected);
    EXPECT_EQ(axis().StartMove(Middle()).error().code, ErrorCode::kDisconnected);
    EXPECT_EQ(axis().WaitUntilStill(Seconds(1), {}).error().code, ErrorCode::kDisconnected);
    EXPECT_EQ(axis().Stop().error().code, ErrorCode::kDisconnected);
    EXPECT_EQ(axis().EmergencyStop().error().code, ErrorCode::kDisconnected);
  }
}

// Promise 5. Example failure is a program that ends while an arm is on its way.
TEST_P(AxisConformance, DestructorStopsTheMotor) {
  Home();
  StartLongMove();
  subject_.axis.reset();
  EXPECT_FALSE(Turns());
}

// Errors: kTimeout. Example failure is a wait that gives up and leaves the motor running.
TEST_P(AxisConformance, TimeoutStopsTheAxis) {
  Home();
  StartLongMove();
  const auto still = axis().WaitUntilStill(Seconds(0.01), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().code, ErrorCode::kTimeout);
  EXPECT_FALSE(Turns());
}

// Errors: kCancelled. Example failure is a Ctrl-C that waits for the end of the move.
TEST_P(AxisConformance, CancelStopsTheAxis) {
  Home();
  Seconds expected{0};
  StartLongMove(&expected);
  std::stop_source stop;
  stop.request_stop();
  const Seconds before = subject_.clock->Now();
  const auto still = axis().WaitUntilStill(Seconds(600), stop.get_token());
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().code, ErrorCode::kCancelled);
  EXPECT_LT(subject_.clock->Now() - before, expected / 4);
  EXPECT_FALSE(Turns());
}

// State(). Example failure is an axis that calls itself homed after a homing that was cancelled.
TEST_P(AxisConformance, CancelledHomingLeavesItNotHomed) {
  std::stop_source stop;
  stop.request_stop();
  const auto homed = axis().Home(stop.get_token());
  if (homed.ok() && subject_.open_again) GTEST_SKIP() << "it stood at its mark";
  ASSERT_FALSE(homed.ok());
  EXPECT_EQ(homed.error().code, ErrorCode::kCancelled);
  EXPECT_FALSE(axis().State()->homed);
  EXPECT_FALSE(Turns());
}

// Example failure is a session whose record does not say which stage it was measured with.
TEST_P(AxisConformance, SaysWhatItIs) {
  EXPECT_FALSE(axis().identity().empty());
  EXPECT_EQ(axis().identity().find('\n'), std::string::npos);
}

// State(). Example failure is an axis that is `moving` only once somebody waits for it.
TEST_P(AxisConformance, ReportsMovingOnTheWay) {
  Home();
  StartLongMove();
  EXPECT_TRUE(axis().State()->moving);
  const double early = axis().State()->position;
  subject_.clock->SleepFor(Seconds(0.2));
  EXPECT_NE(axis().State()->position, early);
}

}  // namespace gonio
