// SPDX-License-Identifier: Apache-2.0
// The promises of Monitor in drivers/light.h, asked of any monitor. Include in one .cpp per test
// program and instantiate as in tests/conformance/axis.h.

#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include "drivers/light.h"

namespace gonio {

struct MonitorSubject {
  std::function<void(double)> shine;  // the true power, relative to that at calibration
  double noise = 0;                   // relative standard deviation of a reading, and what shines
  double stray = 1e-6;                // power of what shines besides
  double brightest = 2;               // power that can be had
  double dazzles = 0;                 // power that is too much for it; 0: nothing is
  std::string absent;                 // why there is none, so that tests are skipped
  std::unique_ptr<Monitor> monitor;   // last, so that it goes before its device
};
using MonitorFactory = std::function<MonitorSubject()>;

class MonitorConformance : public testing::TestWithParam<MonitorFactory> {
 protected:
  void SetUp() override {
    subject_ = GetParam()();
    if (!subject_.absent.empty()) GTEST_SKIP() << subject_.absent;
  }
  Monitor& monitor() { return *subject_.monitor; }
  void ExpectReads(double power) {
    const auto reading = monitor().Read();
    ASSERT_TRUE(reading.ok()) << reading.error().message;
    EXPECT_NEAR(*reading, power, subject_.stray + 6 * subject_.noise * power);
  }

  MonitorSubject subject_;
};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(MonitorConformance);

TEST_P(MonitorConformance, DescribesItself) {
  EXPECT_FALSE(monitor().name().empty());
  EXPECT_FALSE(monitor().identity().empty());
}

// Promise 1. Example failure is a meter that reads in dBm.
TEST_P(MonitorConformance, IsProportionalToTheLight) {
  for (const double power : {1.0, 0.5, 0.25, 0.01, 1.2}) {
    if (power > subject_.brightest) continue;
    subject_.shine(power);
    ExpectReads(power);
  }
}

// Promise 2. Example failure is a meter that is asked for the reading it has instead of a new one.
TEST_P(MonitorConformance, NeverRepeatsAReadingFromBefore) {
  for (int i = 0; i < 3; ++i) {
    subject_.shine(1);
    ExpectReads(1);
    subject_.shine(0.1);
    ExpectReads(0.1);
  }
}

// Promise 3. Example failure is a drift correction by 9.9e37.
TEST_P(MonitorConformance, SaysWhenItCannotMeasure) {
  if (subject_.dazzles == 0) GTEST_SKIP() << "nothing is too bright for it";
  subject_.shine(subject_.dazzles);
  const auto reading = monitor().Read();
  ASSERT_FALSE(reading.ok());
  EXPECT_EQ(reading.error().code, ErrorCode::kRefused);
  EXPECT_NE(reading.error().message.find(monitor().name()), std::string::npos);
  subject_.shine(1);
  ExpectReads(1);
}

}  // namespace gonio
