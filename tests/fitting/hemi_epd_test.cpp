// SPDX-License-Identifier: Apache-2.0
#include "fitting/hemi_epd.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/units.h"

namespace gonio {
namespace {

// log of 2 pi int_0^1 (exp(kappa u^gamma) - 1) du by tanh-sinh quadrature, which resolves both
// ends: an integral written from the definition, for kappa up to 600 (exp fits a double).
double LogIntegralByQuadrature(const Lobe& lobe) {
  const double step = 1.0 / 512;
  double sum = 0;
  for (int i = -3000; i <= 3000; ++i) {
    const double t = i * step;
    const double s = kPi / 2 * std::sinh(t);
    const double weight = kPi / 2 * std::cosh(t) / std::pow(std::cosh(s), 2) / 2;
    if (!(weight > 1e-300)) continue;
    // u = (1 + tanh s) / 2, by its logarithm: u^gamma keeps its digits near both ends.
    const double log_u = -std::log1p(std::exp(-2 * s));
    sum += weight * std::expm1(lobe.kappa * std::exp(lobe.gamma * log_u));
  }
  return std::log(2 * kPi * sum * step);
}

TEST(HemiEpd, IntegralAgreesWithNumericalIntegration) {
  for (const double kappa : {1e-9, 1e-3, 0.1, 1.0, 4.0, 16.0, 100.0, 600.0}) {
    for (const double gamma : {0.01, 0.1, 1.0, 3.0, 50.0, 1e3, 1e4}) {
      const Lobe lobe{kappa, gamma};
      EXPECT_NEAR(LogHemisphereIntegral(lobe), LogIntegralByQuadrature(lobe), 1e-9)
          << "kappa " << kappa << ", gamma " << gamma;
    }
  }
}

TEST(HemiEpd, IntegralOfALobeThatVanishesIsLinearInKappa) {
  for (const double gamma : {0.01, 1.0, 1e4}) {
    EXPECT_NEAR(LogHemisphereIntegral({1e-250, gamma}),
                std::log(2 * kPi) + std::log(1e-250) - std::log1p(gamma), 1e-10);
  }
}

// For gamma = 1 the integral is 2 pi ((exp(kappa) - 1) / kappa - 1).
TEST(HemiEpd, IntegralIsFiniteForHugeLobes) {
  for (const double kappa : {1e3, 1e5}) {
    EXPECT_NEAR(LogHemisphereIntegral({kappa, 1}), std::log(2 * kPi) + kappa - std::log(kappa),
                1e-6)
        << kappa;
  }
}

// Edahiro et al., eq. 5, has Gamma(1/g) - Gamma(1/g, -k), k < 0, that is the lower incomplete gamma
// function of a positive number; it belongs to lobes exp(k cos^g) with k < 0. Ours is its
// continuation to positive exponents, sum_m x^m / (m! (g m + 1)): for k = -kappa the series
// alternates.
TEST(HemiEpd, SeriesContinuesTheIncompleteGammaFunctionOfThePaper) {
  for (const double gamma : {0.5, 1.0, 2.0, 5.0}) {
    for (const double k : {-0.1, -1.0, -3.0}) {
      // int_0^1 exp(k u^g) du by Simpson's rule against the incomplete gamma function by its own
      // series in the other direction: (-k)^(-1/g) / g gammainc_lower(1/g, -k).
      const double a = 1 / gamma;
      double term = std::exp(k) / a;  // lower(a, x) = x^a e^-x sum x^n / (a (a+1) ... (a+n))
      double lower = term;
      for (int n = 1; n < 60; ++n) lower += term *= -k / (a + n);
      const double by_gamma_function = lower / gamma;  // (-k)^a cancels
      double by_series = 1;
      double power = 1;
      for (int m = 1; m < 60; ++m) by_series += (power *= k / m) / (gamma * m + 1);
      EXPECT_NEAR(by_series, by_gamma_function, 1e-12) << gamma << " " << k;
    }
  }
}

TEST(HemiEpd, LogarithmOfALobeIsThatOfTheLobe) {
  for (const double kappa : {1e-6, 0.1, 1.0, 10.0}) {
    for (const double theta_h : {0.0, 0.3, 1.2}) {
      const Lobe lobe{kappa, 3};
      const double log_cos = LogCos(theta_h);
      EXPECT_NEAR(LogLobe(lobe, log_cos), std::log(EvalLobe(lobe, log_cos)), 1e-7);
    }
  }
  // Where the lobe itself is below the smallest double.
  EXPECT_NEAR(LogLobe({1, 1e4}, LogCos(1.0)), 1e4 * LogCos(1.0), 1e-6);
}

TEST(HemiEpd, SlopesAreTheDerivatives) {
  const double h = 1e-6;
  for (const double theta_h : {0.01, 0.4, 1.3}) {
    const double log_cos = LogCos(theta_h);
    for (const auto& [k, g] : std::vector<std::pair<double, double>>{{-2, 0}, {0.5, 2}, {1, -1}}) {
      const auto eval = [&](double log_kappa, double log_gamma) {
        return BoundedLobe(log_kappa, log_gamma).Slopes(log_cos).f_r;
      };
      const LobeSlopes slopes = BoundedLobe(k, g).Slopes(log_cos);
      EXPECT_NEAR(slopes.by_log_kappa, (eval(k + h, g) - eval(k - h, g)) / (2 * h), 1e-7);
      EXPECT_NEAR(slopes.by_log_gamma, (eval(k, g + h) - eval(k, g - h)) / (2 * h), 1e-7);
    }
  }
}

TEST(HemiEpd, FillsColumnsWithWhatItHasOneByOne) {
  Eigen::ArrayXd log_cos(60);
  for (int i = 0; i < 60; ++i) log_cos[i] = LogCos(RadFromDeg(1.5 * i));
  BoundedLobe::Columns columns;
  // Broad, narrow enough to vanish on the way, held at its bounds.
  for (const auto& [k, g] :
       std::vector<std::pair<double, double>>{{-2, 0}, {0.5, 7}, {-13, 3}, {5, 20}, {-20, -8}}) {
    const BoundedLobe lobe(k, g);
    lobe.Fill(log_cos, &columns);
    ASSERT_EQ(columns.rows(), 60);
    for (int i = 0; i < 60; ++i) {
      const LobeSlopes slopes = lobe.Slopes(log_cos[i]);
      EXPECT_NEAR(columns(i, 0), slopes.f_r, 1e-15 + 1e-14 * slopes.f_r);
      EXPECT_NEAR(columns(i, 1), slopes.by_log_kappa, 1e-14 * slopes.by_log_kappa);
      EXPECT_NEAR(columns(i, 2), slopes.by_log_gamma, 1e-14 * std::abs(slopes.by_log_gamma));
    }
  }
}

TEST(HemiEpd, BoundsHoldALobeAndItsSlopes) {
  const BoundedLobe beyond(BoundedLobe::kMaxLogKappa + 1, BoundedLobe::kMinLogGamma - 1);
  EXPECT_DOUBLE_EQ(beyond.lobe().kappa, std::exp(BoundedLobe::kMaxLogKappa));
  EXPECT_DOUBLE_EQ(beyond.lobe().gamma, std::exp(BoundedLobe::kMinLogGamma));
  EXPECT_EQ(beyond.Slopes(-0.1).by_log_kappa, 0);
  EXPECT_EQ(beyond.Slopes(-0.1).by_log_gamma, 0);
  EXPECT_EQ(BoundedLobe::Clamp({9, -9}),
            Eigen::Vector2d(BoundedLobe::kMaxLogKappa, BoundedLobe::kMinLogGamma));
}

}  // namespace
}  // namespace gonio
