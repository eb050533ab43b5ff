// SPDX-License-Identifier: Apache-2.0
#include "fitting/spline.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>

#include "core/units.h"
#include "fitting/dsbrdf.h"
#include "sim/random.h"

namespace gonio {
namespace {

double Evaluate(const Eigen::VectorXd& coefficients, double theta_d) {
  const SplineBasis basis = BasisAt(theta_d, static_cast<int>(coefficients.size()));
  double sum = 0;
  for (int j = 0; j < 4; ++j) sum += basis.weight[j] * coefficients[basis.first + j];
  return sum;
}

Eigen::VectorXd RandomCoefficients(int knots, std::uint64_t seed) {
  Random random(seed, 0);
  Eigen::VectorXd coefficients(knots);
  for (double& c : coefficients) c = random.Normal();
  return coefficients;
}

// The basis function j of `degree` by the recursion of de Boor and Cox; knot i is at (i - 3)
// spacings.
double CoxDeBoor(int j, int degree, double x) {
  const auto knot = [](int i) { return i - 3.0; };
  if (degree == 0) return x >= knot(j) && x < knot(j + 1) ? 1 : 0;
  return (x - knot(j)) / degree * CoxDeBoor(j, degree - 1, x) +
         (knot(j + degree + 1) - x) / degree * CoxDeBoor(j + 1, degree - 1, x);
}

// Value, slope and curvature at `at` of the one cubic the spline is between two knots.
Eigen::Vector3d CubicAt(const Eigen::VectorXd& coefficients, double from, double to, double at) {
  Eigen::Matrix4d powers;
  Eigen::Vector4d heights;
  for (int i = 0; i < 4; ++i) {
    const double x = from + (to - from) * (0.1 + 0.8 * i / 3);
    powers.row(i) << 1, x - at, std::pow(x - at, 2), std::pow(x - at, 3);
    heights[i] = Evaluate(coefficients, x);
  }
  const Eigen::Vector4d cubic = powers.fullPivLu().solve(heights);
  return {cubic[0], cubic[1], 2 * cubic[2]};
}

TEST(BasisAt, WeighsWithNonNegativeNumbersThatSumToOne) {
  for (int knots = kMinKnots; knots <= kMaxKnots; ++knots) {
    for (int i = 0; i <= 1000; ++i) {
      const SplineBasis basis = BasisAt(i / 1000.0 * kPi / 2, knots);
      double sum = 0;
      for (const double weight : basis.weight) {
        EXPECT_GE(weight, 0);
        sum += weight;
      }
      EXPECT_NEAR(sum, 1, 1e-14);
      EXPECT_GE(basis.first, 0);
      EXPECT_LE(basis.first + 4, knots);
    }
  }
}

TEST(BasisAt, AgreesWithTheRecursionOfDeBoorAndCox) {
  for (const int knots : {4, 5, 7, 20}) {
    for (int i = 0; i < 200; ++i) {
      const double theta_d = (i + 0.37) / 200 * kPi / 2;
      const SplineBasis basis = BasisAt(theta_d, knots);
      const double x = theta_d / (kPi / 2) * (knots - 3);
      for (int j = 0; j < knots; ++j) {
        const bool near = j >= basis.first && j < basis.first + 4;
        EXPECT_NEAR(near ? basis.weight[j - basis.first] : 0, CoxDeBoor(j, 3, x), 1e-14);
      }
    }
  }
}

TEST(BasisAt, IsContinuousInValueSlopeAndCurvatureAcrossKnots) {
  for (const int knots : {5, 7, 12, 20}) {
    const Eigen::VectorXd coefficients = RandomCoefficients(knots, 1);
    const double spacing = kPi / 2 / (knots - 3);
    for (int k = 1; k < knots - 3; ++k) {
      const double knot = k * spacing;
      const Eigen::Vector3d left = CubicAt(coefficients, knot - spacing, knot, knot);
      const Eigen::Vector3d right = CubicAt(coefficients, knot, knot + spacing, knot);
      EXPECT_NEAR(left[0], right[0], 1e-10);
      EXPECT_NEAR(left[1], right[1], 1e-8);
      EXPECT_NEAR(left[2], right[2], 1e-6);
    }
  }
}

TEST(BasisAt, ClampsWhatLiesOutside) {
  for (const int knots : {4, 7, 20}) {
    EXPECT_EQ(BasisAt(-0.3, knots).weight, BasisAt(0, knots).weight);
    EXPECT_EQ(BasisAt(-0.3, knots).first, 0);
    EXPECT_EQ(BasisAt(2, knots).weight, BasisAt(kPi / 2, knots).weight);
    EXPECT_EQ(BasisAt(2, knots).first, knots - 4);
  }
}

TEST(KnotPosition, TurnsIntoTheIdentityWhenUsedAsCoefficients) {
  for (const int knots : {4, 7, 20}) {
    Eigen::VectorXd coefficients(knots);
    for (int j = 0; j < knots; ++j) coefficients[j] = KnotPosition(j, knots);
    for (int i = 0; i <= 100; ++i) {
      const double theta_d = i / 100.0 * kPi / 2;
      EXPECT_NEAR(Evaluate(coefficients, theta_d), theta_d, 1e-14);
    }
  }
}

TEST(KnotPosition, IsWhereTheCoefficientPullsMost) {
  constexpr int kKnots = 7;
  for (int j = 1; j < kKnots - 1; ++j) {
    const Eigen::VectorXd one = Eigen::VectorXd::Unit(kKnots, j);
    const double peak = KnotPosition(j, kKnots);
    EXPECT_NEAR(Evaluate(one, peak), 2.0 / 3, 1e-14);
    // At the ends of the range theta_d is clamped.
    EXPECT_LT(Evaluate(one, peak - 0.01), j > 1 ? 0.6666 : 0.6667);
    EXPECT_LT(Evaluate(one, peak + 0.01), j < kKnots - 2 ? 0.6666 : 0.6667);
  }
}

}  // namespace
}  // namespace gonio
