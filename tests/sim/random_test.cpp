// SPDX-License-Identifier: Apache-2.0
#include "sim/random.h"

#include <gtest/gtest.h>

#include <functional>

namespace gonio {
namespace {

struct Moments {
  double mean = 0;
  double variance = 0;
};

Moments MomentsOf(const std::function<double()>& draw) {
  constexpr int kDraws = 200000;
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = draw();
    sum += x;
    squares += x * x;
  }
  const double mean = sum / kDraws;
  return {mean, squares / kDraws - mean * mean};
}

TEST(Random, UniformIsInsideZeroToOne) {
  Random random(1, 0);
  const Moments moments = MomentsOf([&] { return random.Uniform(); });
  EXPECT_NEAR(moments.mean, 0.5, 0.003);
  EXPECT_NEAR(moments.variance, 1.0 / 12, 0.001);
}

TEST(Random, NormalIsStandard) {
  Random random(2, 0);
  const Moments moments = MomentsOf([&] { return random.Normal(); });
  EXPECT_NEAR(moments.mean, 0, 0.01);
  EXPECT_NEAR(moments.variance, 1, 0.02);
}

TEST(Random, PoissonHasItsMeanAsVarianceOnBothSidesOfTheApproximation) {
  for (const double mean : {0.1, 3.0, 49.0, 51.0, 1000.0}) {
    Random random(3, 0);
    const Moments moments = MomentsOf([&] { return random.Poisson(mean); });
    EXPECT_NEAR(moments.mean / mean, 1, 0.03) << mean;
    EXPECT_NEAR(moments.variance / mean, 1, 0.03) << mean;
  }
  EXPECT_EQ(Random(3, 0).Poisson(0), 0);
}

TEST(Random, StreamsAndSeedsAreUnrelated) {
  EXPECT_EQ(Random(5, 1).Uniform(), Random(5, 1).Uniform());
  EXPECT_NE(Random(5, 1).Uniform(), Random(5, 2).Uniform());
  EXPECT_NE(Random(5, 1).Uniform(), Random(6, 1).Uniform());
}

}  // namespace
}  // namespace gonio
