// SPDX-License-Identifier: Apache-2.0
#include "acquisition/frame_taker.h"

#include <gmock/gmock.h>

#include <deque>

#include "tests/acquisition/simulated_rig.h"

namespace gonio {
namespace {

using testing::HasSubstr;

// Reads what it was given, in that order.
class ScriptedMonitor final : public Monitor {
 public:
  explicit ScriptedMonitor(std::deque<double> readings) : readings_(std::move(readings)) {}
  const std::string& name() const override { return name_; }
  const std::string& identity() const override { return name_; }
  Result<double> Read() override {
    const double reading = readings_.front();
    readings_.pop_front();
    return reading;
  }
  std::size_t left() const { return readings_.size(); }

 private:
  std::deque<double> readings_;
  const std::string name_ = "monitor";
};

class FrameTakerTest : public testing::Test {
 protected:
  FrameTakerTest() : rig_(paper_) {
    PoseMeasurer measurer(rig_.rig, rig_.devices, rig_.clock);
    EXPECT_TRUE(measurer.Prepare({}).ok());
    rig_.rig.max_light_change = 0.02;
  }
  ScriptedMonitor& Script(std::deque<double> readings) {
    auto monitor = std::make_unique<ScriptedMonitor>(std::move(readings));
    ScriptedMonitor& script = *monitor;
    rig_.devices.monitor = std::move(monitor);
    return script;
  }
  Result<Exposure> Take(double monitor) {
    return FrameTaker(rig_.rig, rig_.devices).Take(Seconds(0.01), monitor, {});
  }

  FlatBrdf paper_{Rgb::Constant(0.3)};
  SimulatedRig rig_;
};

TEST_F(FrameTakerTest, GivesAFrameTheMeanOfTheLightBeforeAndAfter) {
  Script({0.99});
  const auto taken = Take(1);
  ASSERT_TRUE(taken.ok());
  EXPECT_DOUBLE_EQ(taken->monitor, 0.995);
}

// Example failure is a frame reduced with a reading from before the lamp's flicker.
TEST_F(FrameTakerTest, TakesAFrameAgainDuringWhichTheLightChanged) {
  const ScriptedMonitor& script = Script({0.9, 0.91});
  const auto taken = Take(1);
  ASSERT_TRUE(taken.ok());
  EXPECT_DOUBLE_EQ(taken->monitor, 0.905);
  EXPECT_EQ(script.left(), 0u);
}

// Every third pair agrees by chance. Example failure is a taker that remembers none of the others.
TEST_F(FrameTakerTest, FindsALightThatFlickersAndSometimesAgrees) {
  std::deque<double> readings;
  for (int i = 0; i < 20; ++i) {
    for (const double reading : {1.1, 1.1, 1.0}) readings.push_back(reading);
  }
  Script(readings);
  FrameTaker taker(rig_.rig, rig_.devices);
  int taken = 0;
  for (; taken < 10; ++taken) {
    if (!taker.Take(Seconds(0.01), 1, {}).ok()) break;
  }
  EXPECT_GT(taken, 1);
  EXPECT_LT(taken, 6);
}

TEST_F(FrameTakerTest, LooksAtALightThatWasSwitchedOn) {
  FrameTaker taker(rig_.rig, rig_.devices);
  Script({1, 1.01, 1, 1.01, 1, 1.01, 1, 1.01, 1});
  EXPECT_TRUE(taker.CheckSteady(rig_.clock).ok());
  Script({1, 1.05, 1, 1.05, 1, 1.05, 1, 1.05, 1});
  const auto unsteady = taker.CheckSteady(rig_.clock);
  ASSERT_FALSE(unsteady.ok());
  EXPECT_EQ(unsteady.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(unsteady.error().message, HasSubstr("flickers by 4.9 % from reading to reading"));
  rig_.rig.max_light_change.reset();
  EXPECT_TRUE(taker.CheckSteady(rig_.clock).ok());  // nobody asked
}

TEST_F(FrameTakerTest, GivesUpOnALightThatIsNeverSteady) {
  Script({0.9, 1, 0.9, 1});
  const auto taken = Take(1);
  ASSERT_FALSE(taken.ok());
  EXPECT_EQ(taken.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(taken.error().message,
              HasSubstr("monitor: the light is not steady within 2 % (light.max_change): it "
                        "changed by more during 3 exposures in "
                        "a row, at last by 10 %"));
}

TEST_F(FrameTakerTest, SeesTheLightGoOutDuringAnExposure) {
  Script({0.0});
  const auto taken = Take(1);
  ASSERT_FALSE(taken.ok());
  EXPECT_THAT(taken.error().message, HasSubstr("the light is out"));
}

TEST_F(FrameTakerTest, DoesNotLookAgainUnlessItIsAskedTo) {
  rig_.rig.max_light_change.reset();
  const ScriptedMonitor& script = Script({0.5});
  const auto taken = Take(1);
  ASSERT_TRUE(taken.ok());
  EXPECT_EQ(taken->monitor, 1);
  EXPECT_EQ(script.left(), 1u);
}

}  // namespace
}  // namespace gonio
