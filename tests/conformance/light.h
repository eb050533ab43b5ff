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
  }
  Light& light() { return *subject_.light; }

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

}  // namespace gonio
