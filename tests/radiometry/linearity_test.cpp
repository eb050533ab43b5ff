// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/linearity.h"

#include <gmock/gmock.h>

#include "tests/radiometry/synthetic_sensor.h"

namespace gonio {
namespace {

// Points as a series of flats gives them; `read` counts of true counts. Each of the two frames has
// its own draw of the light.
std::vector<TransferPoint> Points(double (*read)(double), double noise, std::uint64_t seed) {
  Random random(seed, 3);
  std::vector<TransferPoint> points;
  for (int k = 1; k <= 12; ++k) {
    TransferPoint p;
    p.exposure = 0.1 * k;
    p.monitor = 0.9 + 0.2 * random.Uniform();
    const double truth = 3000 * p.exposure * p.monitor;
    p.mean = (read(truth * (1 + noise * random.Normal())) +
              read(truth * (1 + noise * random.Normal()))) /
             2;
    p.mean_sigma = 0.3;
    p.mean += p.mean_sigma * random.Normal();
    points.push_back(p);
  }
  return points;
}

double Straight(double counts) { return counts; }
double Bent(double counts) { return counts * (1 - 0.05 * counts / 4000); }

TEST(Linearity, CallsAStraightSensorStraight) {
  int significant = 0;
  Scores scores;
  for (int seed = 0; seed < 1000; ++seed) {
    const auto fit = MeasureLinearity(Points(Straight, 0.01, seed), {.light_noise = 0.01});
    ASSERT_TRUE(fit.ok());
    significant += fit->significant;
    EXPECT_LT(fit->max_residual, 0.05);
    for (const LinearityKnot& knot : fit->table.knots()) {
      scores.Add((knot.factor.value - 1) / knot.factor.sigma);
    }
  }
  EXPECT_LE(significant, 6);  // one in a thousand
  EXPECT_NEAR(scores.mean(), 0, 0.05);
  EXPECT_NEAR(scores.deviation(), 1, 0.05);
}

// The table may have another scale than the truth, which the responsivity takes up; ratios count.
TEST(Linearity, StraightensABentSensorWithinItsErrors) {
  Scores scores;
  for (int seed = 0; seed < 800; ++seed) {
    const auto fit = MeasureLinearity(Points(Bent, 0.002, seed), {.light_noise = 0.002});
    ASSERT_TRUE(fit.ok());
    EXPECT_TRUE(fit->significant);
    const auto low = fit->table.Factor(Bent(600));
    const auto high = fit->table.Factor(Bent(2400));
    ASSERT_TRUE(low && high);
    const double found = low->value / high->value;
    const double truth = (600 / Bent(600)) / (2400 / Bent(2400));
    scores.Add((found / truth - 1) / std::hypot(low->relative(), high->relative()));
  }
  EXPECT_NEAR(scores.mean(), 0, 0.2);
  // Interpolated between two knots of independent errors; they follow the line by 1/12 each.
  EXPECT_NEAR(scores.deviation(), 1, 0.1);
}

TEST(Linearity, SeesTheLargestDeviation) {
  const auto fit = MeasureLinearity(Points(Bent, 0, 1), {});
  ASSERT_TRUE(fit.ok());
  // From 0.4 % low to 4.5 % low; without light noise the line goes by the bright ones, 3.6 % low.
  EXPECT_NEAR(fit->max_residual, 0.032, 0.006);
  EXPECT_LT(fit->max_residual_sigma, 0.01);
}

TEST(Linearity, TakesDarkCurrentForWhatItIs) {
  std::vector<TransferPoint> points;
  for (int k = 1; k <= 8; ++k) {
    TransferPoint p;
    p.exposure = 0.1 * k;
    p.monitor = 1.0 / k;  // the light fades, so that the dark share grows
    p.mean = 1000 * p.exposure * p.monitor + 50 * p.exposure;
    p.mean_sigma = 0.1;
    points.push_back(p);
  }
  const auto fit = MeasureLinearity(points, {.dark_rate = 50});
  ASSERT_TRUE(fit.ok());
  EXPECT_LT(fit->max_residual, 1e-9);
  EXPECT_FALSE(fit->significant);
  EXPECT_TRUE(MeasureLinearity(points, {})->significant);
}

TEST(Linearity, KnowsNothingAboveItsLastKnot) {
  const auto table = Linearity::FromKnots({{1000, {1.1, 0.02}}, {500, {1, 0.01}}});
  ASSERT_TRUE(table.ok());
  EXPECT_DOUBLE_EQ(*table->Correct(1000), 1100);
  EXPECT_DOUBLE_EQ(*table->Correct(750), 750 * 1.05);
  EXPECT_DOUBLE_EQ(*table->Correct(-3), -3);
  EXPECT_FALSE(table->Correct(1000.5));
  EXPECT_FALSE(table->Correct(std::nan("")));
  EXPECT_DOUBLE_EQ(table->Factor(750)->sigma, std::hypot(0.01, 0.005));
  EXPECT_TRUE(Linearity::Identity(4000).is_identity());
  EXPECT_FALSE(Linearity::FromKnots({{5, {1, 0}}, {5, {1, 0}}}).ok());
  EXPECT_FALSE(Linearity::FromKnots({{5, {-1, 0}}}).ok());
  EXPECT_FALSE(Linearity::FromKnots({}).ok());
}

TEST(Linearity, NeedsThreeUnsaturatedExposures) {
  std::vector<TransferPoint> points = Points(Straight, 0, 1);
  for (std::size_t i = 2; i < points.size(); ++i) points[i].clipped = 0.2;
  const auto fit = MeasureLinearity(points, {});
  ASSERT_FALSE(fit.ok());
  EXPECT_EQ(fit.error().message, "linearity: 2 unsaturated exposures, needs 3");
}

}  // namespace
}  // namespace gonio
