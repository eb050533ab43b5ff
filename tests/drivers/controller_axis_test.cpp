// SPDX-License-Identifier: Apache-2.0
// The rules of motion, asked of a controller that says whatever a test wants. What real ones say is
// in wire_axes_test.cpp.
#include "drivers/controller_axis.h"

#include <gmock/gmock.h>

#include <vector>

namespace gonio {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct Script {
  ControllerStatus status{.position = 0, .homed = true, .moving = false, .fault = {}};
  std::function<void(ControllerStatus&)> next;  // before each answer
  std::vector<std::string> told;
};

class Scripted final : public MotionController {
 public:
  explicit Scripted(Script* script) : script_(script) {}
  std::string Identity() const override { return "scripted"; }
  Result<ControllerStatus> Status() override {
    if (script_->next) script_->next(script_->status);
    return script_->status;
  }
  Result<void> Enable() override {
    script_->status.enabled = true;
    return Told("enable");
  }
  Result<void> StartHoming() override { return Told("home"); }
  Result<void> StartMove(double) override { return Told("move"); }
  Result<void> StartStop() override {
    script_->status.moving = false;
    return Told("stop");
  }
  Result<void> StartEmergencyStop() override { return Told("emergency stop"); }

 private:
  Result<void> Told(const char* what) {
    script_->told.push_back(what);
    return {};
  }
  Script* const script_;
};

class ControllerAxisTest : public testing::Test {
 protected:
  ControllerAxisTest() {
    ControllerAxisSettings settings;
    settings.name = "arm";
    settings.limits = {.min_position = -2,
                       .max_position = 2,
                       .max_speed = 0.5,
                       .acceleration = 1,
                       .position_tolerance = 1e-3};
    axis_ =
        std::make_unique<ControllerAxis>(std::make_unique<Scripted>(&script_), settings, &clock_);
  }
  Error Missed(double by) {
    script_.status.position = 0;
    EXPECT_TRUE(axis_->StartMove(1).ok());
    script_.status.position = 1 + by;
    const auto still = axis_->WaitUntilStill(Seconds(10), {});
    return still ? Error{ErrorCode::kCancelled, "arrived"} : still.error();
  }

  ManualClock clock_;
  Script script_;
  std::unique_ptr<ControllerAxis> axis_;
};

TEST_F(ControllerAxisTest, SaysHowLongAMoveShouldTake) {
  EXPECT_DOUBLE_EQ(axis_->StartMove(2)->count(), 2 / 0.5 + 0.5 / 1);
  EXPECT_EQ(axis_->identity(), "scripted");
}

TEST_F(ControllerAxisTest, ANearMissMayBeRepeated) {
  EXPECT_EQ(Missed(0.9e-3).message, "arrived");
  EXPECT_EQ(Missed(2e-3).code, ErrorCode::kTimeout);
  EXPECT_EQ(Missed(-0.2).code, ErrorCode::kProtocol);
}

// Example failure is an arm that pushes against a cable until its time is up.
TEST_F(ControllerAxisTest, NoticesAMotorThatStandsAndSaysThatItMoves) {
  ASSERT_TRUE(axis_->StartMove(1).ok());
  script_.status.moving = true;
  script_.status.position = 0.3;
  const auto still = axis_->WaitUntilStill(Seconds(60), {});
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().code, ErrorCode::kProtocol);
  EXPECT_EQ(still.error().message, "arm: stalled at 17.1887 deg on its way to 57.2958 deg");
  EXPECT_LT(clock_.Now().count(), 2.2);
  EXPECT_THAT(script_.told, ElementsAre("move", "stop"));
  EXPECT_EQ(axis_->StartMove(1).error().message, "arm: is not homed since: it stalled");
}

TEST_F(ControllerAxisTest, LetsASlowMotorGoOn) {
  ASSERT_TRUE(axis_->StartMove(1).ok());
  script_.next = [this](ControllerStatus& status) {
    status.position = std::min(1.0, clock_.Now().count() / 50);
    status.moving = status.position < 1;
  };
  EXPECT_TRUE(axis_->WaitUntilStill(Seconds(60), {}).ok());
}

TEST_F(ControllerAxisTest, BelievesInNoReferenceAfterAFault) {
  script_.status.fault = "following error";
  EXPECT_FALSE(axis_->State()->homed);
  script_.status.fault.clear();
  EXPECT_FALSE(axis_->State()->homed);
  EXPECT_EQ(axis_->StartMove(1).error().message, "arm: is not homed since: following error");
  EXPECT_THAT(script_.told, IsEmpty());
  EXPECT_TRUE(axis_->Home({}).ok());
  EXPECT_TRUE(axis_->StartMove(1).ok());
}

// Example failure is a session that goes on by itself once the emergency stop is released.
TEST_F(ControllerAxisTest, OnlyHomingGivesTheMotorPower) {
  script_.status.enabled = false;
  EXPECT_EQ(axis_->StartMove(1).error().message,
            "arm: is not homed since: the motor was without power");
  script_.status.enabled = true;
  EXPECT_FALSE(axis_->StartMove(1).ok());
  script_.status.enabled = false;
  EXPECT_TRUE(axis_->Home({}).ok());
  EXPECT_THAT(script_.told, ElementsAre("enable", "home"));
  EXPECT_TRUE(axis_->StartMove(1).ok());
}

TEST_F(ControllerAxisTest, SaysSoIfItDoesNotStop) {
  script_.next = [](ControllerStatus& status) { status.moving = true; };
  const auto stopped = axis_->EmergencyStop();
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().message, "arm: still moves 5 s after it was told to stop");
}

}  // namespace
}  // namespace gonio
