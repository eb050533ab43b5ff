// SPDX-License-Identifier: Apache-2.0
#include "fitting/fit.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "brdf/analytic.h"
#include "core/error.h"
#include "fitting/generalised_log.h"
#include "fitting/posterior.h"
#include "fitting/starts.h"
#include "tests/core/temp_dir.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

const AnalyticBrdf& Paint() {
  static const AnalyticBrdf brdf("paint",
                                 {Lambert{{0.2, 0.3, 0.4}}, Ggx{.roughness = 0.15, .ior = 1.5}});
  return brdf;
}

// Mean absolute difference of log f_r at 300 poses.
double LogError(const Brdf& truth, const Brdf& other) {
  Random random(99, 0);
  double sum = 0;
  for (int n = 0; n < 300; ++n) {
    const DirectionPair pair = RandomPose(random);
    sum += (truth.Eval(pair)->log() - other.Eval(pair)->log()).abs().mean() / 300;
  }
  return sum;
}

double MeanSigma(const DsbrdfFit& fit) {
  Random random(98, 0);
  double sum = 0;
  for (int n = 0; n < 100; ++n) {
    const Prediction prediction = fit.Predict(ToHalfDiff(RandomPose(random)));
    sum += (prediction.sigma / prediction.f_r).mean() / 100;
  }
  return sum;
}

TEST(FitOptions, PassTheirOwnCheckByDefault) { EXPECT_NO_THROW(FitOptions{}.Check()); }

TEST(FitOptions, AreRefusedByName) {
  const auto complaint = [](const FitOptions& options) {
    const std::vector<BrdfSample> samples = Readings(Paint(), 3, 0.01, 1);
    return MessageOf<ConfigError>([&] { FitDsbrdf(samples, GenericPrior(), options); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(complaint({.floor = 0}), "fit.floor: must be > 0");
  EXPECT_EQ(complaint({.floor = kInfinity}), "fit.floor: must be > 0");
  EXPECT_EQ(complaint({.huber = nan}), "fit.huber: must be > 0");
  EXPECT_EQ(complaint({.model_error = 0}), "fit.model_error: must be > 0");
  EXPECT_EQ(complaint({.model_error_weight = -1}), "fit.model_error_weight: must be >= 0");
  EXPECT_EQ(complaint({.max_iterations = 0}), "fit.max_iterations: must be > 0");
  EXPECT_EQ(complaint({.tolerance = 0}), "fit.tolerance: must be > 0");
  EXPECT_EQ(complaint({.start_samples = 0}), "fit.start_samples: must be > 0");
}

TEST(FitDsbrdf, RecoversAMaterialOfItsFamily) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Dsbrdf truth = SyntheticMaterial(seed);
    const DsbrdfFit fit = FitDsbrdf(Readings(truth, 300, 0.01, seed), GenericPrior());
    EXPECT_TRUE(fit.summary().converged) << seed;
    EXPECT_LT(LogError(truth, fit), 0.01) << seed;
  }
}

TEST(FitDsbrdf, ComesNearToMaterialsOutsideItsFamily) {
  const DsbrdfFit fit = FitDsbrdf(Readings(Paint(), 300, 0.01, 1), GenericPrior());
  EXPECT_TRUE(fit.summary().converged);
  EXPECT_LT(LogError(Paint(), fit), 0.15);
  EXPECT_GT(fit.summary().model_error, 0.01);
}

TEST(FitDsbrdf, ConvergesForEveryShape) {
  const std::vector<BrdfSample> samples = Readings(SyntheticMaterial(1), 80, 0.02, 1);
  for (int lobes = 1; lobes <= kMaxLobes; ++lobes) {
    const DsbrdfFit fit = FitDsbrdf(samples, GenericPrior({lobes, 5}));
    EXPECT_TRUE(fit.summary().converged) << lobes << " lobes";
    EXPECT_EQ(fit.model().shape().lobes, lobes);
  }
}

TEST(FitDsbrdf, CountsWhatItUsed) {
  std::vector<BrdfSample> samples = Readings(Paint(), 25, 0.02, 1);
  samples[3].sigma[1] = kInfinity;
  const FitOptions options{.floor = 0.02};
  const FitSummary summary = FitDsbrdf(samples, GenericPrior(), options).summary();
  EXPECT_EQ(summary.samples, 25);
  EXPECT_EQ(summary.residuals, 74);
  EXPECT_EQ(summary.floor, 0.02);
  EXPECT_EQ(summary.reason, "cost no longer falls");
  EXPECT_GT(summary.starts, 1);
  EXPECT_GT(summary.iterations, 0);
}

TEST(FitDsbrdf, SaysThatItDidNotConverge) {
  const FitOptions options{.max_iterations = 1, .tolerance = 1e-15};
  const DsbrdfFit fit = FitDsbrdf(Readings(Paint(), 100, 0.01, 1), GenericPrior(), options);
  EXPECT_FALSE(fit.summary().converged);
  EXPECT_EQ(fit.summary().reason, "iteration limit");
  EXPECT_TRUE(fit.model().parameters().allFinite());
}

TEST(FitDsbrdf, IsTheSameBitForBitEachTime) {
  const std::vector<BrdfSample> samples = Readings(Paint(), 60, 0.02, 2);
  const DsbrdfFit a = FitDsbrdf(samples, GenericPrior());
  const DsbrdfFit b = FitDsbrdf(samples, GenericPrior());
  EXPECT_TRUE((a.model().parameters().array() == b.model().parameters().array()).all());
  EXPECT_TRUE((a.covariance().array() == b.covariance().array()).all());
  EXPECT_EQ(a.summary().cost, b.summary().cost);
}

TEST(FitDsbrdf, DoesNotMindTheOrderOfSamples) {
  std::vector<BrdfSample> samples = Readings(Paint(), 60, 0.02, 3);
  const DsbrdfFit forwards = FitDsbrdf(samples, GenericPrior());
  std::reverse(samples.begin(), samples.end());
  const DsbrdfFit backwards = FitDsbrdf(samples, GenericPrior());
  for (const BrdfSample& sample : samples) {
    const Rgb f = *forwards.Eval(sample.directions);
    EXPECT_LT(((*backwards.Eval(sample.directions) - f) / f).abs().maxCoeff(), 1e-6);
  }
}

TEST(FitDsbrdf, ShrugsOffAFewWildReadings) {
  const Dsbrdf truth = SyntheticMaterial(5);
  std::vector<BrdfSample> samples = Readings(truth, 200, 0.01, 5);
  const double clean = LogError(truth, FitDsbrdf(samples, GenericPrior()));
  for (std::size_t n = 0; n < samples.size(); n += 20) samples[n].f_r *= n % 40 == 0 ? 5 : 0.2;
  const double robust = LogError(truth, FitDsbrdf(samples, GenericPrior()));
  const double squares = LogError(truth, FitDsbrdf(samples, GenericPrior(), {.huber = 1e9}));
  EXPECT_LT(robust, clean + 0.02);
  EXPECT_LT(robust, 0.5 * squares);
}

TEST(FitDsbrdf, TakesASingleReading) {
  const std::vector<BrdfSample> samples = Readings(Paint(), 1, 0.01, 6);
  const DsbrdfFit fit = FitDsbrdf(samples, GenericPrior());
  EXPECT_TRUE(fit.summary().converged);
  const Rgb f_r = *fit.Eval(samples[0].directions);
  EXPECT_LT((f_r / samples[0].f_r).log().abs().maxCoeff(), 0.1);
  EXPECT_TRUE(fit.covariance().allFinite());
}

TEST(FitDsbrdf, TakesTheSameReadingManyTimes) {
  const std::vector<BrdfSample> samples(50, Readings(Paint(), 1, 0.01, 6)[0]);
  EXPECT_TRUE(FitDsbrdf(samples, GenericPrior()).summary().converged);
}

TEST(FitDsbrdf, TakesNegativeAndZeroReadings) {
  std::vector<BrdfSample> samples = Readings(Paint(), 40, 0.02, 7);
  samples[4].f_r = Rgb(-0.01, 0, -5);
  const DsbrdfFit fit = FitDsbrdf(samples, GenericPrior());
  EXPECT_TRUE(fit.summary().converged);
  for (BrdfSample& sample : samples) sample.f_r = -1e-3 * Rgb::Ones();
  const DsbrdfFit dark = FitDsbrdf(samples, GenericPrior());
  EXPECT_TRUE(dark.summary().converged);
  EXPECT_LT(dark.Eval(samples[0].directions)->maxCoeff(), 0.01);
}

TEST(FitDsbrdf, RefusesReadingsWithoutAnyFiniteSigma) {
  std::vector<BrdfSample> samples = Readings(Paint(), 4, 0.02, 8);
  for (BrdfSample& sample : samples) sample.sigma.setConstant(kInfinity);
  const std::string expected = "nothing to fit: no sample has a channel with a finite sigma";
  const Prior prior = GenericPrior();
  EXPECT_EQ(MessageOf<ConfigError>([&] { FitDsbrdf(samples, prior); }), expected);
  EXPECT_EQ(MessageOf<ConfigError>([&] { FitDsbrdf({}, prior); }), expected);
  EXPECT_EQ(MessageOf<ConfigError>([&] { RefitDsbrdf(samples, prior, {}, prior.mean, 0.03); }),
            expected);
}

TEST(FitDsbrdf, LearnsAnUnmeasuredChannelFromTheOthers) {
  std::vector<BrdfSample> samples = Readings(SyntheticMaterial(6), 60, 0.02, 9);
  for (BrdfSample& sample : samples) sample.sigma[1] = kInfinity;
  const DsbrdfFit fit = FitDsbrdf(samples, GenericPrior());
  const Prediction prediction = fit.Predict(ToHalfDiff(samples[0].directions));
  EXPECT_GT(prediction.sigma[1], 3 * prediction.sigma[0]);
  EXPECT_TRUE(prediction.f_r.isFinite().all());
}

TEST(RefitDsbrdf, IsAtAMinimumWhenItSaysSo) {
  const Prior prior = GenericPrior();
  const FitOptions options;
  const std::vector<BrdfSample> samples = Readings(Paint(), 300, 0.01, 1);
  const Posterior posterior(
      samples, prior,
      {.floor = options.floor, .huber = options.huber, .model_error = options.model_error});
  for (const Eigen::VectorXd& start : FitStarts(samples, prior)) {
    const DsbrdfFit fit = RefitDsbrdf(samples, prior, options, start, options.model_error);
    if (!fit.summary().converged) continue;
    Eigen::VectorXd gradient;
    Eigen::MatrixXd hessian;
    const double cost = posterior.Linearise(fit.model().parameters(), &gradient, &hessian);
    EXPECT_NEAR(cost, fit.summary().cost, 1e-9 * cost);
    // By how much a full Gauss-Newton step would lower the cost.
    EXPECT_LT(0.5 * gradient.dot(hessian.llt().solve(gradient)), 1e-3 * (1 + cost));
  }
}

TEST(RefitDsbrdf, FindsFromNearbyWhatAllStartsFind) {
  const std::vector<BrdfSample> samples = Readings(SyntheticMaterial(7), 81, 0.02, 10);
  const Prior prior = GenericPrior();
  const std::span<const BrdfSample> before(samples.data(), 80);
  const DsbrdfFit last = FitDsbrdf(before, prior);
  const DsbrdfFit fresh = FitDsbrdf(samples, prior);
  const DsbrdfFit refit =
      RefitDsbrdf(samples, prior, {}, last.model().parameters(), last.summary().model_error);
  EXPECT_TRUE(refit.summary().converged);
  EXPECT_EQ(refit.summary().starts, 1);
  EXPECT_LT(refit.summary().iterations, fresh.summary().iterations);
  EXPECT_LT(LogError(fresh, refit), 0.005);
}

TEST(Predict, HasTheMeanThatEvalGives) {
  const DsbrdfFit fit = FitDsbrdf(Readings(Paint(), 40, 0.02, 11), GenericPrior());
  Random random(1, 0);
  for (int n = 0; n < 50; ++n) {
    const HalfDiff angles = ToHalfDiff(RandomPose(random));
    EXPECT_LT((fit.Predict(angles).f_r - *fit.Eval(angles)).abs().maxCoeff(), 1e-12);
    EXPECT_GT(fit.Predict(angles).sigma.minCoeff(), 0);
  }
}

TEST(Predict, IsSurerTheMoreWasMeasured) {
  const Dsbrdf truth = SyntheticMaterial(8);
  const std::vector<BrdfSample> samples = Readings(truth, 320, 0.02, 12);
  FitOptions options;
  options.model_error = 0.005;
  double last = kInfinity;
  for (const std::size_t count : {5, 20, 80, 320}) {
    const double sigma =
        MeanSigma(FitDsbrdf(std::span(samples.data(), count), GenericPrior(), options));
    EXPECT_LT(sigma, 0.8 * last) << count;
    last = sigma;
  }
  EXPECT_LT(last, 0.03);
}

TEST(Predict, PropagatesTheCovarianceOfTheParameters) {
  const DsbrdfShape shape{2, 5};
  const DsbrdfFit fit =
      FitDsbrdf(Readings(SyntheticMaterial(9, shape), 40, 0.02, 13), GenericPrior(shape));
  const HalfDiff angles{0.2, 0.6, 1.2};
  const Prediction prediction = fit.Predict(angles);
  constexpr double kStep = 1e-5;
  const Eigen::VectorXd& p = fit.model().parameters();
  Eigen::MatrixXd jacobian(kChannels, p.size());
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(p.size(), i);
    jacobian.col(i) =
        (*Dsbrdf(shape, p + step).Eval(angles) - *Dsbrdf(shape, p - step).Eval(angles)) /
        (2 * kStep);
  }
  const FitSummary& summary = fit.summary();
  for (int c = 0; c < kChannels; ++c) {
    const double known = jacobian.row(c) * fit.covariance() * jacobian.row(c).transpose();
    const double off_model =
        summary.model_error / GeneralisedLogSlope(prediction.f_r[c], summary.floor);
    const double expected = std::sqrt(known + off_model * off_model);
    EXPECT_NEAR(prediction.sigma[c], expected, 1e-4 * expected);
  }
}

}  // namespace
}  // namespace gonio
