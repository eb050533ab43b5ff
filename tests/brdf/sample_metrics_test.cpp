// SPDX-License-Identifier: Apache-2.0
#include "brdf/sample_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/brdf/function_brdf.h"

namespace gonio {
namespace {

FunctionBrdf Flat(double f_r) {
  return FunctionBrdf([f_r](const HalfDiff&) { return Rgb::Constant(f_r); });
}

BrdfSample At(double theta_i_deg, double theta_o_deg, double f_r, double sigma) {
  return {{FromSpherical(RadFromDeg(theta_i_deg), 0), FromSpherical(RadFromDeg(theta_o_deg), 2)},
          Rgb::Constant(f_r),
          Rgb::Constant(sigma)};
}

TEST(SampleMetrics, AreWhatTheirFormulasSay) {
  const std::vector<BrdfSample> samples = {At(60, 0, 0.4, 0.1), At(0, 60, 0.2, 0.05)};
  const SampleMetrics m = CompareSamples(samples, Flat(0.3));
  EXPECT_EQ(m.readings, 6);
  EXPECT_EQ(m.left_out, 0);
  EXPECT_NEAR(m.male, (std::log(1.2 / 1.15) + std::log(1.3 / 1.2)) / 2, 1e-12);
  EXPECT_NEAR(m.rms, 0.1, 1e-12);
  EXPECT_NEAR(m.z_rms, std::sqrt((1 + 4) / 2.0), 1e-12);
  const double a = std::log(0.201 / 0.151);
  const double b = std::log(0.101 / 0.151);
  EXPECT_NEAR(m.log_relative_rms, std::sqrt((a * a + b * b) / 2), 1e-12);
}

// A dark sample read as -0.1 by chance: far by its sigma, not by what anybody would see.
TEST(SampleMetrics, CountNegativeReadingsAsBlackInLogarithmsOnly) {
  const SampleMetrics m = CompareSamples(std::vector{At(30, 30, -0.1, 0.1)}, Flat(0));
  EXPECT_EQ(m.male, 0);
  EXPECT_NEAR(m.z_rms, 1, 1e-12);
}

TEST(SampleMetrics, LeaveOutWhatCannotBeCompared) {
  std::vector<BrdfSample> samples = {At(85, 30, 1, 1), At(30, 85, 1, 1), At(30, 30, 1, 1)};
  samples[2].sigma[1] = std::numeric_limits<double>::infinity();
  const SampleMetrics m = CompareSamples(samples, Flat(1));
  EXPECT_EQ(m.readings, 2);
  EXPECT_EQ(m.left_out, 7);
  EXPECT_TRUE(std::isnan(CompareSamples({}, Flat(1)).male));
}

}  // namespace
}  // namespace gonio
