// SPDX-License-Identifier: Apache-2.0
#include "fitting/starts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fitting/slice.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

TEST(FitStarts, BeginWithThePriorsMean) {
  const Prior prior = GenericPrior();
  const std::vector<Eigen::VectorXd> starts = FitStarts({}, prior);
  ASSERT_GE(starts.size(), 2u);
  EXPECT_EQ(starts[0], prior.mean);
}

TEST(FitStarts, AreTheSameForAnyOrderOfSamples) {
  const Prior prior = GenericPrior();
  std::vector<BrdfSample> samples = Readings(SyntheticMaterial(1), 41, 0.02, 1);
  const std::vector<Eigen::VectorXd> starts = FitStarts(samples, prior);
  std::reverse(samples.begin(), samples.end());
  EXPECT_EQ(FitStarts(samples, prior), starts);
}

TEST(FitStarts, AreFiniteForEveryShapeAndAnySamples) {
  std::vector<BrdfSample> samples = Readings(SyntheticMaterial(2), 10, 0.02, 2);
  samples[0].f_r.setConstant(-1);
  samples[1].sigma.setConstant(std::numeric_limits<double>::infinity());
  samples[1].f_r.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (int lobes = 1; lobes <= kMaxLobes; ++lobes) {
    const Prior prior = GenericPrior({lobes, 5});
    for (const std::size_t count : {0, 1, 2, 10}) {
      for (const Eigen::VectorXd& start : FitStarts(std::span(samples.data(), count), prior)) {
        ASSERT_EQ(start.size(), prior.shape.size());
        EXPECT_TRUE(start.allFinite()) << lobes << " lobes, " << count << " samples";
      }
    }
  }
}

TEST(FitStarts, StandAtTheDiffuseLevelAndThePeakThatWereRead) {
  const Prior prior = GenericPrior();
  std::vector<BrdfSample> samples;
  for (int i = 0; i < 9; ++i) {  // diffuse 0.1, 0.2, 0.3; peak 2, 4, 6
    const bool peak = i == 4;
    const HalfDiff angles{RadFromDeg(peak ? 0.1 : 50.0), RadFromDeg(20 + i), kPi / 2};
    samples.push_back(
        {ToDirections(angles), (peak ? 20 : 1) * Rgb(0.1, 0.2, 0.3), Rgb::Constant(0.01)});
  }
  const std::vector<Eigen::VectorXd> starts = FitStarts(samples, prior);
  for (std::size_t s = 1; s < starts.size(); ++s) {
    const Slice slice(prior.shape, starts[s], 0.4);
    for (int c = 0; c < kChannels; ++c) {
      EXPECT_NEAR(std::expm1(slice.kappa(c, 0)), 0.1 * (c + 1), 1e-9);
      EXPECT_NEAR(std::expm1(slice.kappa(c, 2)), 1.9 * (c + 1), 1e-9);
      if (s == 1) continue;
      EXPECT_GT(slice.gamma(c, 2), Slice(prior.shape, starts[s - 1], 0.4).gamma(c, 2));
    }
  }
}

}  // namespace
}  // namespace gonio
