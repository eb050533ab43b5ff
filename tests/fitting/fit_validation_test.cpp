// SPDX-License-Identifier: Apache-2.0
// Known answers: is what a fit says about its own error true?
#include <gtest/gtest.h>

#include <cmath>

#include "fitting/fit.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

constexpr int kSeeds = 20;
constexpr int kPlaces = 60;

// Errors of predictions in units of their own sigma, for many materials of the family at places
// that were not measured.
std::vector<double> NormalisedErrors(int poses, double noise, const FitOptions& options) {
  std::vector<double> errors;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Dsbrdf truth = SyntheticMaterial(seed);
    const DsbrdfFit fit =
        FitDsbrdf(Readings(truth, poses, noise, 100 + seed), GenericPrior(), options);
    EXPECT_TRUE(fit.summary().converged) << seed;
    Random random(seed, 2);
    for (int n = 0; n < kPlaces; ++n) {
      const HalfDiff angles = ToHalfDiff(RandomPose(random));
      const Prediction prediction = fit.Predict(angles);
      const Rgb error = (prediction.f_r - *truth.Eval(angles)) / prediction.sigma;
      errors.insert(errors.end(), error.begin(), error.end());
    }
  }
  return errors;
}

double ShareWithin(const std::vector<double>& errors, double sigmas) {
  double inside = 0;
  for (const double error : errors) inside += std::abs(error) <= sigmas ? 1 : 0;
  return inside / static_cast<double>(errors.size());
}

constexpr double kNinetyPercent = 1.6449;

TEST(LaplaceCovariance, CoversTheTruthOfItsFamilyAsOftenAsItSays) {
  // Hardly any model error: what is left is what the covariance of the parameters says.
  FitOptions options;
  options.model_error = 0.002;
  for (const int poses : {60, 150}) {
    const std::vector<double> errors = NormalisedErrors(poses, 0.03, options);
    const double coverage = ShareWithin(errors, kNinetyPercent);
    EXPECT_GT(coverage, 0.80) << poses << " poses";
    EXPECT_LT(coverage, 0.98) << poses << " poses";
    EXPECT_GT(ShareWithin(errors, 4), 0.98) << poses << " poses";
  }
}

TEST(LaplaceCovariance, IsNotTooSureWithTheDefaultOptions) {
  const std::vector<double> errors = NormalisedErrors(60, 0.02, {});
  EXPECT_GT(ShareWithin(errors, kNinetyPercent), 0.85);
  EXPECT_GT(ShareWithin(errors, 4), 0.98);
}

TEST(Fit, RecoversThePlantedModelError) {
  const Dsbrdf truth = SyntheticMaterial(30);
  for (const double planted : {0.05, 0.15}) {
    std::vector<BrdfSample> samples = Readings(truth, 500, 0.01, 31);
    Random random(32, 0);
    for (BrdfSample& sample : samples) {
      for (int c = 0; c < kChannels; ++c) sample.f_r[c] *= std::exp(planted * random.Normal());
    }
    FitOptions options;
    options.floor = 1e-3;
    const double estimate = FitDsbrdf(samples, GenericPrior(), options).summary().model_error;
    EXPECT_NEAR(estimate, planted, 0.3 * planted);
  }
}

}  // namespace
}  // namespace gonio
