// SPDX-License-Identifier: Apache-2.0
#include "fitting/posterior.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "fitting/generalised_log.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr DsbrdfShape kSmall{.lobes = 2, .knots = 5};

Eigen::VectorXd Near(const Eigen::VectorXd& parameters, double spread, std::uint64_t seed) {
  Random random(seed, 0);
  Eigen::VectorXd near = parameters;
  for (double& p : near) p += spread * random.Normal();
  return near;
}

// Central differences of the cost.
Eigen::VectorXd NumericGradient(const Posterior& posterior, const Eigen::VectorXd& p) {
  constexpr double kStep = 1e-5;
  Eigen::VectorXd gradient(p.size());
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(p.size(), i);
    gradient[i] = (posterior.Cost(p + step) - posterior.Cost(p - step)) / (2 * kStep);
  }
  return gradient;
}

TEST(GeneralisedLog, IsTheLogarithmFarAboveTheFloor) {
  EXPECT_NEAR(GeneralisedLog(5, 1e-3), std::log(5), 1e-6);
  EXPECT_NEAR(GeneralisedLogSlope(5, 1e-3), 1.0 / 5, 1e-7);
}

TEST(GeneralisedLog, IsLinearAndOddAboutItsValueAtZero) {
  constexpr double kFloor = 0.03;
  const double zero = GeneralisedLog(0, kFloor);
  EXPECT_NEAR(zero, std::log(kFloor), 1e-15);
  for (const double f : {1e-6, 1e-3, 0.1, 10.0}) {
    EXPECT_NEAR(GeneralisedLog(f, kFloor) - zero, zero - GeneralisedLog(-f, kFloor), 1e-12);
    EXPECT_LT(GeneralisedLog(-f, kFloor), GeneralisedLog(f, kFloor));
  }
  EXPECT_NEAR((GeneralisedLog(1e-6, kFloor) - zero) / 1e-6, 1 / (2 * kFloor), 1e-6);
}

TEST(GeneralisedLog, HasTheSlopeFiniteDifferencesHave) {
  for (const double floor : {1e-3, 0.03, 1.0}) {
    for (const double f : {-2.0, -0.01, 0.0, 1e-3, 0.2, 50.0}) {
      const double step = 1e-5 * (floor + std::abs(f));
      const double numeric =
          (GeneralisedLog(f + step, floor) - GeneralisedLog(f - step, floor)) / (2 * step);
      EXPECT_NEAR(GeneralisedLogSlope(f, floor), numeric, 1e-7 * numeric);
    }
  }
}

TEST(Posterior, CostsWhatTheFormulaSays) {
  const Dsbrdf truth = SyntheticMaterial(1, kSmall);
  const Prior prior = GenericPrior(kSmall);
  const PosteriorOptions options{.floor = 0.02, .huber = 1.5, .model_error = 0.04};
  const std::vector<BrdfSample> samples = Readings(truth, 30, 0.1, 1);
  const Dsbrdf guess(kSmall, Near(truth.parameters(), 0.1, 2));
  double expected = 0;
  for (const BrdfSample& sample : samples) {
    const Rgb f = *guess.Eval(sample.directions);
    for (int c = 0; c < kChannels; ++c) {
      const double y = sample.f_r[c];
      const double slope = 1 / std::sqrt(y * y + 4 * 0.02 * 0.02);
      const double s = std::hypot(sample.sigma[c] * slope, 0.04);
      const double r = std::abs((std::asinh(y / 0.04) - std::asinh(f[c] / 0.04)) / s);
      expected += r <= 1.5 ? r * r / 2 : 1.5 * r - 1.5 * 1.5 / 2;
    }
  }
  const Eigen::VectorXd deviation = guess.parameters() - prior.mean;
  expected += 0.5 * deviation.dot(prior.covariance.ldlt().solve(deviation));
  const Posterior posterior(samples, prior, options);
  EXPECT_EQ(posterior.residual_count(), 90);
  EXPECT_NEAR(posterior.Cost(guess.parameters()), expected, 1e-8 * expected);
}

TEST(Posterior, LinearisesToTheSameCost) {
  const Dsbrdf truth = SyntheticMaterial(2);
  const Prior prior = GenericPrior();
  const Posterior posterior(Readings(truth, 50, 0.05, 1), prior, {});
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Eigen::VectorXd p = Near(truth.parameters(), 0.3, seed);
    const double cost = posterior.Cost(p);
    EXPECT_NEAR(posterior.Linearise(p, &gradient, &hessian), cost, 1e-12 * cost);
    EXPECT_EQ((hessian - hessian.transpose()).cwiseAbs().maxCoeff(), 0);
    EXPECT_EQ(hessian.llt().info(), Eigen::Success);
  }
}

TEST(Posterior, HasTheGradientFiniteDifferencesHave) {
  const Prior prior = GenericPrior(kSmall);
  // From all residuals within Huber's square to nearly all beyond, and for sharp steps away from
  // the data the prior alone.
  for (const double huber : {1e9, 2.0, 0.1}) {
    for (const double spread : {0.01, 0.3}) {
      const Dsbrdf truth = SyntheticMaterial(3, kSmall);
      const Posterior posterior(Readings(truth, 40, 0.05, 4), prior, {.huber = huber});
      const Eigen::VectorXd p = Near(truth.parameters(), spread, 5);
      Eigen::VectorXd gradient;
      Eigen::MatrixXd hessian;
      posterior.Linearise(p, &gradient, &hessian);
      const Eigen::VectorXd numeric = NumericGradient(posterior, p);
      EXPECT_LT((gradient - numeric).norm(), 2e-5 * numeric.norm())
          << "huber " << huber << " spread " << spread;
    }
  }
}

TEST(Posterior, IsThePriorAloneWithoutSamples) {
  const Prior prior = GenericPrior(kSmall);
  const Posterior posterior({}, prior, {});
  EXPECT_EQ(posterior.residual_count(), 0);
  EXPECT_EQ(posterior.Cost(prior.mean), 0);
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
  posterior.Linearise(prior.mean, &gradient, &hessian);
  EXPECT_EQ(gradient.norm(), 0);
  const Eigen::MatrixXd identity = hessian * prior.covariance;
  EXPECT_LT((identity - Eigen::MatrixXd::Identity(60, 60)).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(Posterior, HasTheExactHessianWhereNothingIsLeftOver) {
  const Dsbrdf truth = SyntheticMaterial(6, kSmall);
  Prior prior = GenericPrior(kSmall);
  prior.mean = truth.parameters();
  const Posterior posterior(Readings(truth, 60, 0, 7), prior, {.huber = 3});
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
  EXPECT_NEAR(posterior.Linearise(truth.parameters(), &gradient, &hessian), 0, 1e-18);
  EXPECT_LT(gradient.norm(), 1e-6);
  Eigen::VectorXd up;
  Eigen::VectorXd down;
  Eigen::MatrixXd unused;
  constexpr double kStep = 1e-5;
  for (Eigen::Index i = 0; i < gradient.size(); ++i) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(gradient.size(), i);
    posterior.Linearise(truth.parameters() + step, &up, &unused);
    posterior.Linearise(truth.parameters() - step, &down, &unused);
    const Eigen::VectorXd column = (up - down) / (2 * kStep);
    EXPECT_LT((column - hessian.col(i)).norm(), 1e-4 * hessian.col(i).norm()) << i;
  }
}

TEST(Posterior, IgnoresChannelsThatCouldNotBeMeasured) {
  const Dsbrdf truth = SyntheticMaterial(7, kSmall);
  const Prior prior = GenericPrior(kSmall);
  std::vector<BrdfSample> samples = Readings(truth, 20, 0.02, 8);
  samples[3].sigma[1] = samples[11].sigma[2] = kInfinity;
  samples[5].sigma.setConstant(kInfinity);
  const Posterior posterior(samples, prior, {});
  EXPECT_EQ(posterior.residual_count(), 60 - 5);
  const double cost = posterior.Cost(truth.parameters());
  samples[3].f_r[1] = 1e6;
  samples[5].f_r.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(Posterior(samples, prior, {}).Cost(truth.parameters()), cost);
}

TEST(Posterior, TakesNegativeReadings) {
  const Dsbrdf truth = SyntheticMaterial(8, kSmall);
  const Prior prior = GenericPrior(kSmall);
  std::vector<BrdfSample> samples = Readings(truth, 5, 0.02, 9);
  samples[2].f_r.setConstant(-0.01);
  const Posterior posterior(samples, prior, {});
  EXPECT_TRUE(std::isfinite(posterior.Cost(truth.parameters())));
}

TEST(Posterior, DoesNotMindTheOrderOfSamples) {
  const Dsbrdf truth = SyntheticMaterial(9, kSmall);
  const Prior prior = GenericPrior(kSmall);
  std::vector<BrdfSample> samples = Readings(truth, 40, 0.02, 10);
  const double cost = Posterior(samples, prior, {}).Cost(truth.parameters());
  std::reverse(samples.begin(), samples.end());
  EXPECT_NEAR(Posterior(samples, prior, {}).Cost(truth.parameters()), cost, 1e-10 * cost);
}

// Readings with noise of known sigma, and a further error of log f_r that sigma does not know of.
std::vector<BrdfSample> WithModelError(const Dsbrdf& truth, double model_error) {
  std::vector<BrdfSample> samples = Readings(truth, 3000, 0.01, 11);
  Random random(12, 0);
  for (BrdfSample& sample : samples) {
    const Rgb f_r = *truth.Eval(sample.directions);
    for (int c = 0; c < kChannels; ++c) {
      sample.f_r[c] += f_r[c] * (std::exp(model_error * random.Normal()) - 1);
    }
  }
  return samples;
}

double EstimatedModelError(double planted, double huber, double guess, double guess_weight) {
  const Dsbrdf truth = SyntheticMaterial(10);
  Prior prior = GenericPrior();
  prior.mean = truth.parameters();
  const std::vector<BrdfSample> samples = WithModelError(truth, planted);
  Posterior posterior(samples, prior, {.floor = 1e-4, .huber = huber, .model_error = planted});
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
  posterior.Linearise(truth.parameters(), &gradient, &hessian);
  return posterior.EstimateModelError(truth.parameters(), hessian, guess, guess_weight);
}

TEST(EstimateModelError, RecoversAPlantedValue) {
  for (const double planted : {0.02, 0.05, 0.2}) {
    EXPECT_NEAR(EstimatedModelError(planted, 1e9, 0.01, 0), planted, 0.05 * planted);
  }
}

TEST(EstimateModelError, RecoversItWithinAQuarterUnderHubersWeights) {
  for (const double planted : {0.05, 0.2}) {
    EXPECT_NEAR(EstimatedModelError(planted, 1, 0.01, 0), planted, 0.25 * planted);
  }
}

TEST(EstimateModelError, IsPulledTowardsTheGuessByItsWeight) {
  EXPECT_NEAR(EstimatedModelError(0.05, 1e9, 0.5, 1e9), 0.5, 1e-3);
  const double half = EstimatedModelError(0.05, 1e9, 0.5, 9000);
  EXPECT_NEAR(half, std::sqrt((0.05 * 0.05 + 0.5 * 0.5) / 2), 0.01);
}

TEST(EstimateModelError, IsZeroWhereNoiseExplainsEverything) {
  const Dsbrdf truth = SyntheticMaterial(11, kSmall);
  Prior prior = GenericPrior(kSmall);
  prior.mean = truth.parameters();
  const Posterior posterior(Readings(truth, 50, 0, 1), prior, {});
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
  posterior.Linearise(truth.parameters(), &gradient, &hessian);
  EXPECT_EQ(posterior.EstimateModelError(truth.parameters(), hessian, 0.03, 0), 0);
  EXPECT_LT(posterior.EstimateModelError(truth.parameters(), hessian, 0.03, 10), 0.03);
}

TEST(SetModelError, ChangesTheCostAsANewPosteriorWould) {
  const Dsbrdf truth = SyntheticMaterial(12, kSmall);
  const Prior prior = GenericPrior(kSmall);
  const std::vector<BrdfSample> samples = Readings(truth, 20, 0.05, 13);
  Posterior posterior(samples, prior, {.model_error = 0.01});
  posterior.set_model_error(0.2);
  EXPECT_EQ(posterior.options().model_error, 0.2);
  EXPECT_EQ(posterior.Cost(truth.parameters()),
            Posterior(samples, prior, {.model_error = 0.2}).Cost(truth.parameters()));
}

}  // namespace
}  // namespace gonio
