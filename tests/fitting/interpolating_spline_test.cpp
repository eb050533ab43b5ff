// SPDX-License-Identifier: Apache-2.0
#include "fitting/interpolating_spline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace gonio {
namespace {

const std::vector<double> kX = {0, 0.5, 1.1, 2, 2.4, 3};
const std::vector<double> kY = {1, 1.2, 4, 3.9, -1, -1};

class Splines : public testing::TestWithParam<SplineKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, Splines,
                         testing::Values(SplineKind::kNatural, SplineKind::kMonotone));

TEST_P(Splines, GoThroughTheirPointsAndAreConstantBeyond) {
  const InterpolatingSpline spline(kX, kY, GetParam());
  for (std::size_t i = 0; i < kX.size(); ++i) EXPECT_NEAR(spline(kX[i]), kY[i], 1e-12);
  EXPECT_EQ(spline(-5), kY.front());
  EXPECT_EQ(spline(9), kY.back());
}

TEST_P(Splines, FollowAStraightLine) {
  const InterpolatingSpline spline({0, 1, 3, 4}, {1, 3, 7, 9}, GetParam());
  for (double x = 0; x <= 4; x += 0.1) EXPECT_NEAR(spline(x), 1 + 2 * x, 1e-12);
}

TEST_P(Splines, TakeOneOrTwoPoints) {
  EXPECT_EQ(InterpolatingSpline({1}, {5}, GetParam())(7), 5);
  EXPECT_NEAR(InterpolatingSpline({0, 2}, {1, 5}, GetParam())(0.5), 2, 1e-12);
}

TEST(InterpolatingSpline, NaturalHasNoBendAtPointsAndEnds) {
  const InterpolatingSpline spline(kX, kY, SplineKind::kNatural);
  const double h = 1e-4;
  const auto bend = [&](double x) {
    return (spline(x - h) - 2 * spline(x) + spline(x + h)) / (h * h);
  };
  for (std::size_t i = 1; i + 1 < kX.size(); ++i) {
    EXPECT_NEAR(bend(kX[i] - 2 * h), bend(kX[i] + 2 * h), 0.1) << i;
  }
  EXPECT_NEAR(bend(kX.front() + h), 0, 0.05);
  EXPECT_NEAR(bend(kX.back() - h), 0, 0.05);
}

TEST(InterpolatingSpline, MonotoneStaysBetweenNeighbours) {
  const InterpolatingSpline spline(kX, kY, SplineKind::kMonotone);
  for (std::size_t i = 0; i + 1 < kX.size(); ++i) {
    for (double t = 0; t <= 1; t += 0.05) {
      const double y = spline(kX[i] + t * (kX[i + 1] - kX[i]));
      EXPECT_GE(y, std::min(kY[i], kY[i + 1]) - 1e-12);
      EXPECT_LE(y, std::max(kY[i], kY[i + 1]) + 1e-12);
    }
  }
}

}  // namespace
}  // namespace gonio
