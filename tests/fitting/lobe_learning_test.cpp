// SPDX-License-Identifier: Apache-2.0
#include "fitting/lobe_learning.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "brdf/metrics.h"
#include "fitting/fit.h"
#include "tests/fitting/synthetic.h"
#include "tests/fitting/training_set.h"

namespace gonio {
namespace {

constexpr LobeLearningOptions kQuick = {.theta_h = 16, .theta_d = 8};

Prior Learned(std::span<const TrainingMaterial> materials, const LobeLearningOptions& options) {
  Prior prior = GenericPrior({.lobes = 2, .knots = 4});
  LearnLobes(materials, options, &prior);
  return prior;
}

TEST(LearnLobes, GivesAPriorThatIsNarrowerThanTheGenericOneAndUsable) {
  const TrainingSet set;
  const Prior prior = Learned(set.materials(), kQuick);
  const Prior generic = GenericPrior({.lobes = 2, .knots = 4});
  EXPECT_EQ(prior.covariance, prior.covariance.transpose());
  EXPECT_EQ(prior.covariance.llt().info(), Eigen::Success);
  EXPECT_LT(prior.covariance.trace(), 0.7 * generic.covariance.trace());
  EXPECT_GT(prior.covariance.diagonal().minCoeff(), 0);
}

TEST(LearnLobes, HelpsAMaterialOfTheFamilyThatItHasNotSeen) {
  const TrainingSet set;
  const Prior prior = Learned(std::span(set.materials()).first(7), kQuick);
  const Prior generic = GenericPrior({.lobes = 2, .knots = 4});
  const Brdf& unseen = *set.materials().back().brdf;
  Random random(3, 0);
  std::vector<BrdfSample> samples;
  for (const double theta_h : {0.05, 0.4, 1.0}) {
    samples.push_back(ReadingAt(unseen, ToDirections({theta_h, 0.4, 1.5}), 0.01, random));
  }
  const MetricOptions metrics{.phi_stride = 30, .theta_d_stride = 5};
  EXPECT_LT(Compare(unseen, FitDsbrdf(samples, prior), metrics).male,
            0.8 * Compare(unseen, FitDsbrdf(samples, generic), metrics).male);
}

TEST(LearnLobes, DoesNotDependOnTheNumberOfThreads) {
  const TrainingSet set;
  LobeLearningOptions two = kQuick;
  two.threads = 2;
  EXPECT_EQ(Learned(set.materials(), kQuick).covariance, Learned(set.materials(), two).covariance);
}

}  // namespace
}  // namespace gonio
