// SPDX-License-Identifier: Apache-2.0
// The promises of drivers/light.h, asked of any light. Include in one .cpp per test program and
// instantiate as in tests/conformance/axis.h.

#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include "drivers/light.h"

namespace gonio {

struct LightSubject {
  std::function<double()> emitted;  // true level, also after the light is gone
  // Sets the device's level behind the driver's back; empty where nobody does.
  std::function<void(double)> turn_by_hand;
  // Of a light with colours: the true level of one, and what lights another behind the driver's
  // back; empty where nobody can.
  std::function<double(LightColour)> emitted_in;
  std::function<void(LightColour)> light_by_hand;
  double nonlinearity = 0;       // relative, of emitted() between off and full
  double stray = 0;              // of emitted(): light of others
  std::string absent;            // why there is none, so that tests are skipped
  std::unique_ptr<Light> light;  // last, so that it goes before its device
};
using LightFactory = std::function<LightSubject()>;

class LightConformance : public testing::TestWithParam<LightFactory> {
 protected:
  void SetUp() override {
    subject_ = GetParam()();
    if (!subject_.absent.empty()) GTEST_SKIP() << subject_.absent;
    if (!light().has_colours()) return;
    const auto selected = light().Select(LightColour::kGreen, {});
    ASSERT_TRUE(selected.ok()) << selected.error().message;
  }
  Light& light() { return *subject_.light; }
  void ExpectAlone(LightColour colour, double level) {
    for (const LightColour one : kLightColours) {
      if (!subject_.emitted_in) break;
      EXPECT_NEAR(subject_.emitted_in(one), one == colour ? level : 0, 0.01)
          << ToString(one) << " while " << ToString(colour);
    }
    const auto selected = light().Selected();
    ASSERT_TRUE(selected.ok()) << selected.error().message;
    EXPECT_EQ(*selected, colour);
    EXPECT_NEAR(*light().Level(), level, 0.01);
  }

  LightSubject subject_;
};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LightConformance);

// Example failure is a light whose full scale is not one.
TEST_P(LightConformance, EmitsTheLevelThatIsSet) {
  for (const double level : {0.0, 0.25, 1.0, 0.5}) {
    ASSERT_TRUE(light().SetLevel(level).ok());
    EXPECT_NEAR(subject_.emitted(), level, 0.01 + subject_.nonlinearity * level);
    const auto read = light().Level();
    ASSERT_TRUE(read.ok());
    EXPECT_NEAR(*read, level, 0.01);
  }
}

// Promise 1. Example failure is a level that is clamped, or wraps around in the device's integer.
TEST_P(LightConformance, RefusesLevelsOutsideZeroToOneAndChangesNothing) {
  ASSERT_TRUE(light().SetLevel(0.5).ok());
  const double before = subject_.emitted();
  for (const double level : {-0.01, 1.01, std::nan(""), HUGE_VAL}) {
    const auto set = light().SetLevel(level);
    ASSERT_FALSE(set.ok()) << level;
    EXPECT_EQ(set.error().code, ErrorCode::kRefused);
    EXPECT_NE(set.error().message.find(light().name()), std::string::npos);
    EXPECT_NEAR(subject_.emitted(), before, subject_.stray);
  }
}

// Promise 2. Example failure is a driver that answers with the last level it sent.
TEST_P(LightConformance, ReadsTheDevice) {
  if (!subject_.turn_by_hand) GTEST_SKIP() << "nobody turns it by hand";
  ASSERT_TRUE(light().SetLevel(0.5).ok());
  subject_.turn_by_hand(0.25);
  ASSERT_TRUE(light().Level().ok());
  EXPECT_NEAR(*light().Level(), 0.25, 0.01);
}

// Promise 3. Example failure is a lamp that burns all night after a crash of the session.
TEST_P(LightConformance, DestructorSwitchesItOff) {
  ASSERT_TRUE(light().SetLevel(1).ok());
  subject_.light.reset();
  EXPECT_NEAR(subject_.emitted(), 0, subject_.stray);
}

// Example failure is red and green that are on together, which is a yellow light.
TEST_P(LightConformance, GivesTheSelectedColourAloneAtTheLevelThatWasSet) {
  if (!light().has_colours()) GTEST_SKIP() << "has no colours";
  ASSERT_TRUE(light().SetLevel(0.5).ok());
  for (const LightColour colour : {LightColour::kRed, LightColour::kBlue, LightColour::kBlue,
                                   LightColour::kGreen, LightColour::kRed}) {
    const auto selected = light().Select(colour, {});
    ASSERT_TRUE(selected.ok()) << selected.error().message;
    ExpectAlone(colour, 0.5);
  }
  ASSERT_TRUE(light().SetLevel(0.25).ok());
  ExpectAlone(LightColour::kRed, 0.25);
}

// Example failure is a change of colour that switches a light on that was off.
TEST_P(LightConformance, SelectsAColourInTheDark) {
  if (!light().has_colours()) GTEST_SKIP() << "has no colours";
  ASSERT_TRUE(light().SetLevel(0).ok());
  ASSERT_TRUE(light().Select(LightColour::kBlue, {}).ok());
  EXPECT_NEAR(subject_.emitted(), 0, subject_.stray);
  ASSERT_TRUE(light().Selected().ok());
  EXPECT_EQ(*light().Selected(), std::nullopt);
  ASSERT_TRUE(light().SetLevel(1).ok());
  ExpectAlone(LightColour::kBlue, 1);
}

// Promise 5. Example failure is an LED that somebody has switched on at the knob.
TEST_P(LightConformance, NoticesTwoColoursAtATime) {
  if (!subject_.light_by_hand) GTEST_SKIP() << "nobody lights another by hand";
  ASSERT_TRUE(light().SetLevel(0.5).ok());
  subject_.light_by_hand(LightColour::kRed);
  const auto selected = light().Selected();
  ASSERT_FALSE(selected.ok());
  EXPECT_EQ(selected.error().code, ErrorCode::kProtocol);
  EXPECT_NE(selected.error().message.find("red and green are on at the same time"),
            std::string::npos)
      << selected.error().message;
  ASSERT_TRUE(light().Select(LightColour::kGreen, {}).ok());
  ExpectAlone(LightColour::kGreen, 0.5);
}

TEST_P(LightConformance, WithoutColoursRefusesToSelectOne) {
  if (light().has_colours()) GTEST_SKIP() << "has colours";
  ASSERT_TRUE(light().SetLevel(0.5).ok());
  const double before = subject_.emitted();
  const auto selected = light().Select(LightColour::kRed, {});
  ASSERT_FALSE(selected.ok());
  EXPECT_EQ(selected.error().code, ErrorCode::kRefused);
  EXPECT_EQ(selected.error().message, light().name() + ": has no red");
  EXPECT_NEAR(subject_.emitted(), before, subject_.stray);
  ASSERT_TRUE(light().Selected().ok());
  EXPECT_EQ(*light().Selected(), std::nullopt);
}

}  // namespace gonio
