// SPDX-License-Identifier: Apache-2.0
#include "fitting/slice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/units.h"
#include "sim/random.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

// One lobe of the same kappa and gamma in every channel and at every theta_d.
Eigen::VectorXd OneLobe(double kappa, double gamma) {
  const DsbrdfShape shape{.lobes = 1, .knots = 4};
  Eigen::VectorXd parameters(shape.size());
  for (int c = 0; c < kChannels; ++c) {
    parameters.segment(shape.Index(c, 0, 0), 4).setConstant(std::log(kappa));
    parameters.segment(shape.Index(c, 0, 1), 4).setConstant(std::log(gamma));
  }
  return parameters;
}

double OneLobeAt(double kappa, double gamma, double theta_h) {
  return Slice({1, 4}, OneLobe(kappa, gamma), 0.5).Eval(0, LogCos(theta_h));
}

// log kappa and log gamma anywhere within their bounds and, in every fourth case, beyond.
Eigen::VectorXd WideParameters(const DsbrdfShape& shape, std::uint64_t seed) {
  Random random(seed, 0);
  const double reach = seed % 4 == 0 ? 1.3 : 0.95;
  Eigen::VectorXd parameters(shape.size());
  for (int c = 0; c < kChannels; ++c) {
    for (int k = 0; k < shape.lobes; ++k) {
      const double kappa = -5.6 + reach * 8.4 * (2 * random.Uniform() - 1);
      const double gamma = 3.1 + reach * 7.7 * (2 * random.Uniform() - 1);
      for (int j = 0; j < shape.knots; ++j) {
        parameters[shape.Index(c, k, 0) + j] = kappa + 0.2 * random.Normal();
        parameters[shape.Index(c, k, 1) + j] = gamma + 0.2 * random.Normal();
      }
    }
  }
  return parameters;
}

// Integral over the hemisphere by the trapezium rule, tanh-spaced for narrow lobes.
template <typename Function>
double OverHemisphere(const Function& f) {
  constexpr int kSteps = 20000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double u = (i + 0.5) / kSteps;
    const double theta = u * u * kPi / 2;
    sum += f(theta) * std::sin(theta) * kPi * u / kSteps;
  }
  return 2 * kPi * sum;
}

// Integral of exp(kappa cos^gamma) - 1 over the hemisphere, 1 / C(kappa, gamma), as the power
// series of the exponential integrated term by term.
double LobeIntegral(double kappa, double gamma) {
  double sum = 0;
  double power = 1;
  for (int n = 1; n < 200; ++n) {
    power *= kappa / n;
    sum += power / (n * gamma + 1);
  }
  return 2 * kPi * sum;
}

TEST(LogCos, IsTheLogarithmAndFiniteAtTheHorizon) {
  EXPECT_EQ(LogCos(0), 0);
  EXPECT_NEAR(LogCos(1), std::log(std::cos(1)), 1e-15);
  EXPECT_NEAR(LogCos(RadFromDeg(89.99)), std::log(std::cos(RadFromDeg(89.99))), 1e-12);
  for (const double theta_h : {kPi / 2, kPi / 2 + 1e-12, std::nextafter(kPi / 2, 2.0)}) {
    EXPECT_TRUE(std::isfinite(LogCos(theta_h)));
    EXPECT_LE(LogCos(theta_h), std::log(1.001e-9));
  }
}

TEST(Slice, SumsItsLobesAsTheFormulaSays) {
  for (int lobes = 1; lobes <= kMaxLobes; ++lobes) {
    const DsbrdfShape shape{.lobes = lobes, .knots = 6};
    const Eigen::VectorXd p = SyntheticMaterial(lobes, shape).parameters();
    for (const double theta_d : {0.0, 0.3, 0.9, 1.5}) {
      const Slice slice(shape, p, theta_d);
      const SplineBasis basis = BasisAt(theta_d, shape.knots);
      for (const double theta_h : {0.0, 0.02, 0.4, 1.2, 1.5}) {
        for (int c = 0; c < kChannels; ++c) {
          double expected = 0;
          for (int k = 0; k < lobes; ++k) {
            double log_kappa = 0;
            double log_gamma = 0;
            for (int j = 0; j < 4; ++j) {
              log_kappa += basis.weight[j] * p[shape.Index(c, k, 0) + basis.first + j];
              log_gamma += basis.weight[j] * p[shape.Index(c, k, 1) + basis.first + j];
            }
            EXPECT_NEAR(slice.kappa(c, k), std::exp(log_kappa), 1e-12 * std::exp(log_kappa));
            EXPECT_NEAR(slice.gamma(c, k), std::exp(log_gamma), 1e-12 * std::exp(log_gamma));
            const double power = std::pow(std::cos(theta_h), std::exp(log_gamma));
            expected += std::exp(std::exp(log_kappa) * power) - 1;
          }
          EXPECT_NEAR(slice.Eval(c, LogCos(theta_h)), expected, 1e-12 * (1 + expected));
        }
      }
    }
  }
}

TEST(Slice, IsAsHighAtThePeakAsKappaSays) {
  EXPECT_NEAR(OneLobeAt(2, 100, 0), std::exp(2) - 1, 1e-12);
  EXPECT_NEAR(OneLobeAt(1e-5, 100, 0), 1e-5, 1e-9);
}

TEST(Slice, TendsToADiffuseConstantAsGammaFalls) {
  const double level = std::exp(0.2) - 1;
  for (const double theta_h : {0.0, 0.5, 1.0, 1.5}) {
    EXPECT_NEAR(OneLobeAt(0.2, 0.0101, theta_h), level, 0.03 * level);
  }
}

TEST(Slice, HasTheGradientFiniteDifferencesHave) {
  constexpr double kStep = 1e-6;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const DsbrdfShape shape{.lobes = 1 + static_cast<int>(seed % kMaxLobes), .knots = 5};
    const Eigen::VectorXd p = WideParameters(shape, seed);
    Random random(seed, 1);
    const double theta_d = random.Uniform() * kPi / 2;
    const double u = random.Uniform();
    const double log_cos = LogCos(u * u * kPi / 2);
    const Slice slice(shape, p, theta_d);
    double gradient[2 * kMaxLobes];
    for (int c = 0; c < kChannels; ++c) {
      const double f = slice.EvalWithGradient(c, log_cos, gradient);
      EXPECT_EQ(f, slice.Eval(c, log_cos));
      for (int k = 0; k < shape.lobes; ++k) {
        for (int q = 0; q < 2; ++q) {
          // Moving all coefficients moves the slice by as much: the weights sum to 1.
          Eigen::VectorXd up = p;
          Eigen::VectorXd down = p;
          up.segment(shape.Index(c, k, q), shape.knots).array() += kStep;
          down.segment(shape.Index(c, k, q), shape.knots).array() -= kStep;
          const double numeric = (Slice(shape, up, theta_d).Eval(c, log_cos) -
                                  Slice(shape, down, theta_d).Eval(c, log_cos)) /
                                 (2 * kStep);
          const double analytic = gradient[2 * k + q];
          EXPECT_NEAR(analytic, numeric, 1e-5 * std::abs(analytic) + 3e-9 * (1 + f))
              << "seed " << seed << " lobe " << k << " quantity " << q;
        }
      }
    }
  }
}

TEST(Slice, HoldsParametersAtTheirBoundsWithZeroDerivative) {
  const DsbrdfShape shape{.lobes = 1, .knots = 4};
  struct Case {
    double log_kappa;
    double log_gamma;
    bool kappa_held;
    bool gamma_held;
  };
  for (const Case& c :
       {Case{2.76, 10.7, false, false}, Case{2.78, 10.7, true, false},
        Case{2.76, 10.9, false, true}, Case{-14.1, 1, true, false}, Case{-13.9, -4.7, false, true},
        Case{1e6, 1e6, true, true}, Case{-1e6, -1e6, true, true}}) {
    const Eigen::VectorXd p = [&] {
      Eigen::VectorXd both(shape.size());
      for (int channel = 0; channel < kChannels; ++channel) {
        both.segment(shape.Index(channel, 0, 0), 4).setConstant(c.log_kappa);
        both.segment(shape.Index(channel, 0, 1), 4).setConstant(c.log_gamma);
      }
      return both;
    }();
    double gradient[2];
    const double f = Slice(shape, p, 0.4).EvalWithGradient(0, LogCos(0.005), gradient);
    EXPECT_TRUE(std::isfinite(f));
    EXPECT_GE(f, 0);
    EXPECT_EQ(gradient[0] == 0, c.kappa_held) << c.log_kappa;
    EXPECT_EQ(gradient[1] == 0, c.gamma_held) << c.log_gamma;
  }
}

TEST(Slice, IsNonNegativeAndFiniteUpToTheHorizon) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const DsbrdfShape shape{.lobes = 3, .knots = 7};
    const Slice slice(shape, WideParameters(shape, seed), 0.01 * static_cast<double>(seed));
    for (const double theta_h : {0.0, 1e-9, 0.1, 1.0, 1.57, kPi / 2}) {
      double gradient[2 * kMaxLobes];
      for (int c = 0; c < kChannels; ++c) {
        const double f = slice.EvalWithGradient(c, LogCos(theta_h), gradient);
        EXPECT_GE(f, 0);
        EXPECT_TRUE(std::isfinite(f));
        for (int a = 0; a < 6; ++a) EXPECT_TRUE(std::isfinite(gradient[a]));
      }
    }
  }
}

TEST(Slice, VanishesAtTheHorizon) {
  for (const double gamma : {1.0, 5.0, 1000.0}) EXPECT_LT(OneLobeAt(3, gamma, kPi / 2), 1e-8);
}

TEST(Slice, FallsFromThePeakToTheHorizon) {
  for (const double gamma : {0.05, 1.0, 30.0, 3000.0}) {
    double last = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= 90; ++i) {
      const double f = OneLobeAt(1.5, gamma, RadFromDeg(i));
      EXPECT_LE(f, last);
      last = f;
    }
  }
}

TEST(LobeNormalisation, HasTheClosedFormOfGammaOne) {
  for (const double kappa : {1e-3, 0.1, 1.0, 5.0, 12.0}) {
    const double closed = 2 * kPi * (std::expm1(kappa) / kappa - 1);
    const double numeric = OverHemisphere([&](double t) { return OneLobeAt(kappa, 1, t); });
    EXPECT_NEAR(numeric, closed, 1e-6 * closed);
    EXPECT_NEAR(LobeIntegral(kappa, 1), closed, 1e-9 * closed);
  }
}

TEST(LobeNormalisation, MakesEveryLobeIntegrateToOne) {
  for (const double kappa : {1e-3, 0.3, 2.0, 10.0}) {
    for (const double gamma : {0.05, 0.5, 3.0, 50.0, 2000.0, 40000.0}) {
      const double c = 1 / LobeIntegral(kappa, gamma);
      const double total = OverHemisphere([&](double t) { return c * OneLobeAt(kappa, gamma, t); });
      EXPECT_NEAR(total, 1, 2e-5) << "kappa " << kappa << " gamma " << gamma;
    }
  }
}

}  // namespace
}  // namespace gonio
