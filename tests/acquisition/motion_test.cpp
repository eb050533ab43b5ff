// SPDX-License-Identifier: Apache-2.0
#include "acquisition/motion.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <deque>

#include "drivers/move_time.h"
#include "tests/acquisition/simulated_rig.h"

namespace gonio {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// An axis that does what the test says and keeps a journal shared by all four.
class ScriptedAxis final : public Axis {
 public:
  ScriptedAxis(int index, const AxisLimits& limits, std::vector<std::string>& journal)
      : name_(kAxisNames[index]), limits_(limits), journal_(journal) {}

  const std::string& name() const override { return name_; }
  const AxisLimits& limits() const override { return limits_; }
  const std::string& identity() const override { return name_; }
  Result<AxisState> State() override {
    return AxisState{.position = position_, .homed = homed, .moving = false};
  }
  Result<void> Home(std::stop_token) override {
    journal_.push_back("home " + name_);
    return {};
  }
  Result<Seconds> StartMove(double position) override {
    journal_.push_back("start " + name_);
    const Seconds expected = TimeOfMove(std::abs(position - position_), limits_);
    targets.push_back(position);
    position_ = position;
    if (!misses.empty()) {
      position_ += misses.front();
      misses.pop_front();
    }
    return expected;
  }
  Result<void> WaitUntilStill(Seconds limit, std::stop_token) override {
    journal_.push_back("wait " + name_);
    last_limit = limit;
    if (wait_error) return *wait_error;
    return {};
  }
  Result<void> Stop() override {
    journal_.push_back("stop " + name_);
    if (stop_error) return *stop_error;
    return {};
  }

  Result<void> EmergencyStop() override { return Stop(); }

  std::vector<double> targets;
  std::deque<double> misses;  // rad, added to the next moves
  std::optional<Error> wait_error;
  std::optional<Error> stop_error;
  bool homed = true;
  Seconds last_limit{0};

 private:
  std::string name_;
  AxisLimits limits_;
  std::vector<std::string>& journal_;
  double position_ = 0.5;
};

class MoveAllTest : public testing::Test {
 protected:
  MoveAllTest() {
    for (int i = 0; i < kAxes; ++i) {
      auto axis = std::make_unique<ScriptedAxis>(i, rig_.axes[i], journal_);
      axes_[i] = axis.get();
      devices_.axes[i] = std::move(axis);
    }
  }

  Result<Arrival> Move(std::stop_token stop = {}) {
    return MoveAll(rig_, devices_, clock_, target_, stop);
  }
  long Count(const std::string& entry) {
    return std::count(journal_.begin(), journal_.end(), entry);
  }

  RigConfig rig_ = DefaultRig();
  ManualClock clock_;
  std::vector<std::string> journal_;
  Devices devices_;
  std::array<ScriptedAxis*, kAxes> axes_;
  ArmAngles target_ = AnglesDeg(10, 20, 30, 40);
};

TEST_F(MoveAllTest, StartsAllAxesBeforeItWaitsForAny) {
  const auto arrival = Move();
  ASSERT_TRUE(arrival.ok());
  EXPECT_THAT(journal_,
              ElementsAre("start light_azimuth", "start light_elevation", "start camera_azimuth",
                          "start camera_elevation", "wait light_azimuth", "wait light_elevation",
                          "wait camera_azimuth", "wait camera_elevation"));
  EXPECT_EQ(arrival->readback, target_);
  EXPECT_EQ(arrival->retries, 0);
}

// Both arms from above: one of them has to turn, below its target.
TEST_F(MoveAllTest, EndsEveryMoveInTheSameDirection) {
  const double approach = RadFromDeg(2);
  for (AxisLimits& limits : rig_.axes) limits.approach = approach;
  ASSERT_TRUE(Move().ok());  // from 0.5 rad, 28.6 deg
  EXPECT_THAT(axes_[kLightAzimuth]->targets,
              ElementsAre(target_[kLightAzimuth] - approach, target_[kLightAzimuth]));
  EXPECT_THAT(axes_[kCameraElevation]->targets, ElementsAre(target_[kCameraElevation]));
  // All turn before any goes on.
  EXPECT_EQ(journal_[4], "wait light_azimuth");
  EXPECT_THAT(std::vector(journal_.begin() + 8, journal_.end()),
              ElementsAre("start light_azimuth", "start light_elevation", "start camera_azimuth",
                          "wait light_azimuth", "wait light_elevation", "wait camera_azimuth"));
}

TEST_F(MoveAllTest, SettlesAfterTheLastAxisIsStill) {
  const auto arrival = Move();
  ASSERT_TRUE(arrival.ok());
  EXPECT_DOUBLE_EQ(clock_.Now().count(), arrival->still.count() + rig_.motion.settle.count());
}

TEST_F(MoveAllTest, GivesALongMoveMoreTime) {
  ASSERT_TRUE(Move().ok());
  const AxisLimits& limits = rig_.axes[kLightAzimuth];
  const double distance = 0.5 - target_[kLightAzimuth];
  EXPECT_DOUBLE_EQ(
      axes_[kLightAzimuth]->last_limit.count(),
      1.5 * TrapezoidTime(distance, limits.max_speed, limits.acceleration).count() + 2);
}

TEST_F(MoveAllTest, LeavesAnAxisWithAnOverheadWhereItIsNearEnough) {
  rig_.axes[kCameraAzimuth].move_overhead = Seconds(27);
  target_[kCameraAzimuth] = 0.5 + RadFromDeg(0.04);
  target_[kLightAzimuth] = 0.5 + RadFromDeg(0.04);
  const auto arrival = Move();
  ASSERT_TRUE(arrival.ok());
  EXPECT_EQ(Count("start camera_azimuth"), 0);
  EXPECT_EQ(Count("start light_azimuth"), 1);
  EXPECT_EQ(arrival->readback[kCameraAzimuth], 0.5);
}

TEST_F(MoveAllTest, SendsOnlyTheAxisThatMissedAgain) {
  axes_[kCameraAzimuth]->misses = {RadFromDeg(0.06)};
  const auto arrival = Move();
  ASSERT_TRUE(arrival.ok());
  EXPECT_EQ(arrival->retries, 1);
  EXPECT_EQ(Count("start camera_azimuth"), 2);
  EXPECT_EQ(Count("start light_azimuth"), 1);
}

TEST_F(MoveAllTest, ReportsTheReadbackNotTheSetPoint) {
  axes_[kLightElevation]->misses = {RadFromDeg(0.03)};
  const auto arrival = Move();
  ASSERT_TRUE(arrival.ok());
  EXPECT_DOUBLE_EQ(arrival->readback[kLightElevation], target_[kLightElevation] + RadFromDeg(0.03));
}

TEST_F(MoveAllTest, RefusesNamingTheAxisAfterAllRetries) {
  const double miss = RadFromDeg(0.06);
  axes_[kCameraElevation]->misses = {miss, miss, miss};
  const auto arrival = Move();
  ASSERT_FALSE(arrival.ok());
  EXPECT_EQ(arrival.error().code, ErrorCode::kRefused);
  EXPECT_EQ(arrival.error().message,
            "camera_elevation: stands at 40.0600 deg after 3 moves to 40.0000 deg, tolerance 0.05 "
            "deg");
  EXPECT_EQ(Count("stop light_azimuth"), 1);
}

TEST_F(MoveAllTest, TreatsATimedOutMoveByWhereItEnded) {
  axes_[kLightAzimuth]->wait_error = Error{ErrorCode::kTimeout, "light_azimuth: slow"};
  axes_[kLightAzimuth]->misses = {1.0};
  const auto arrival = Move();
  ASSERT_TRUE(arrival.ok());
  EXPECT_EQ(arrival->retries, 1);
}

TEST_F(MoveAllTest, StopsEveryAxisWhenOneFails) {
  axes_[kLightElevation]->wait_error = Error{ErrorCode::kDisconnected, "light_elevation: gone"};
  const auto arrival = Move();
  ASSERT_FALSE(arrival.ok());
  EXPECT_EQ(arrival.error().code, ErrorCode::kDisconnected);
  for (const char* name : kAxisNames) EXPECT_EQ(Count(std::string("stop ") + name), 1) << name;
}

TEST_F(MoveAllTest, CallsALostReferenceAFaultAndNotASkippedPose) {
  axes_[kCameraAzimuth]->homed = false;
  const auto arrival = Move();
  ASSERT_FALSE(arrival.ok());
  EXPECT_EQ(arrival.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(arrival.error().message, HasSubstr("camera_azimuth: has lost its reference"));
  EXPECT_EQ(Count("start light_azimuth"), 0);
}

TEST_F(MoveAllTest, IsCancelledWhileSettling) {
  std::stop_source stop;
  stop.request_stop();
  const auto arrival = Move(stop.get_token());
  ASSERT_FALSE(arrival.ok());
  EXPECT_EQ(arrival.error().code, ErrorCode::kCancelled);
  EXPECT_EQ(Count("stop camera_elevation"), 1);
}

TEST_F(MoveAllTest, StopAllStopsAllAndReturnsTheFirstError) {
  axes_[1]->stop_error = Error{ErrorCode::kTimeout, "first"};
  axes_[2]->stop_error = Error{ErrorCode::kTimeout, "second"};
  const auto stopped = StopAll(devices_);
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().message, "first");
  EXPECT_EQ(Count("stop camera_elevation"), 1);
}

TEST_F(MoveAllTest, HomesOneAxisAfterTheOther) {
  ASSERT_TRUE(HomeAll({}, devices_, {}).ok());
  EXPECT_THAT(journal_, ElementsAre("home light_azimuth", "home light_elevation",
                                    "home camera_azimuth", "home camera_elevation"));
}

}  // namespace
}  // namespace gonio
