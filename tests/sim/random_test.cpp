// SPDX-License-Identifier: Apache-2.0
#include "sim/random.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
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

// Shares of draws, against the normal distribution: tails included, where a ziggurat has its own
// way.
TEST(Random, QuickNormalIsStandard) {
  Random random(2, 0);
  constexpr int kDraws = 4000000;
  double fourth = 0;
  std::array<int, 5> beyond{};
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.QuickNormal();
    fourth += x * x * x * x;
    for (int k = 0; k < 5; ++k) beyond[k] += x > k ? 1 : 0;
  }
  EXPECT_NEAR(fourth / kDraws, 3, 0.03);
  for (int k = 0; k < 5; ++k) {
    const double expected = kDraws * std::erfc(k / std::sqrt(2.0)) / 2;
    EXPECT_NEAR(beyond[k], expected, 5 * std::sqrt(expected)) << k;
  }
}

TEST(Random, QuickNormalIsTheSameEverywhere) {
  Random random(2, 0);
  EXPECT_DOUBLE_EQ(random.QuickNormal(), 0.49411567350425761);
}

TEST(Ziggurat, ItsLayersEndAtTheMaximum) {
  const Ziggurat& layers = Ziggurat::Instance();
  const double area = layers.x[0] * layers.y[1];
  for (int i = 1; i < Ziggurat::kLayers; ++i) {
    EXPECT_NEAR(layers.x[i] * (layers.y[i + 1] - layers.y[i]), area, 1e-12) << i;
  }
}

TEST(Random, QuickPoissonHasPoissonsFirstThreeMoments) {
  for (const double mean : {0.1, 3.0, 11.9, 12.1, 100.0, 10000.0}) {
    Random random(3, 0);
    const Moments moments = MomentsOf([&] { return random.QuickPoisson(mean); });
    EXPECT_NEAR(moments.mean, mean, 5 * std::sqrt(mean / 200000));
    EXPECT_NEAR(moments.variance / mean, 1, 0.02) << mean;
    const Moments cubes = MomentsOf(
        [&] { return std::pow((random.QuickPoisson(mean) - mean) / std::sqrt(mean), 3); });
    EXPECT_NEAR(cubes.mean, 1 / std::sqrt(mean), 0.05 + 0.1 / std::sqrt(mean)) << mean;
  }
  EXPECT_EQ(Random(3, 0).QuickPoisson(0), 0);
}

TEST(Random, StreamsAndSeedsAreUnrelated) {
  EXPECT_EQ(Random(5, 1).Uniform(), Random(5, 1).Uniform());
  EXPECT_NE(Random(5, 1).Uniform(), Random(5, 2).Uniform());
  EXPECT_NE(Random(5, 1).Uniform(), Random(6, 1).Uniform());
}

}  // namespace
}  // namespace gonio
