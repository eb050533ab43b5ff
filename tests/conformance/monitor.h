// SPDX-License-Identifier: Apache-2.0
// The promises of Monitor (drivers/light.h), asked of any monitor. Include in one .cpp per test
// program.

#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>

#include "drivers/light.h"

namespace gonio {

struct MonitorSubject {
  std::function<void(double)> shine;  // relative to the power at calibration
  std::unique_ptr<Monitor> monitor;   // goes first: the other may own its device
};
using MonitorFactory = std::function<MonitorSubject()>;

class MonitorConformance : public testing::TestWithParam<MonitorFactory> {
 protected:
  void SetUp() override { subject_ = GetParam()(); }
  MonitorSubject subject_;
};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(MonitorConformance);

// Promise 1. Example failure is a monitor that reads watts, or the reading before.
TEST_P(MonitorConformance, ReadsThePowerThatFallsOnItNow) {
  for (const double power : {1.0, 0.1, 0.0, 1.2}) {
    subject_.shine(power);
    const auto reading = subject_.monitor->Read();
    ASSERT_TRUE(reading.ok()) << reading.error().message;
    EXPECT_NEAR(*reading, power, 0.02);
  }
}

// Promise 2. Example failure is a session whose record does not say at which wavelength it was
// measured.
TEST_P(MonitorConformance, SaysWhatItIs) {
  EXPECT_FALSE(subject_.monitor->identity().empty());
  EXPECT_EQ(subject_.monitor->identity().find('\n'), std::string::npos);
}

}  // namespace gonio
