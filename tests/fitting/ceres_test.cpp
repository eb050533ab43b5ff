// SPDX-License-Identifier: Apache-2.0
// Our Gauss-Newton against Ceres on the same posterior from the same start.
#include <gtest/gtest.h>

#include "fitting/fit.h"
#include "tests/fitting/ceres_posterior.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

struct Case {
  double huber;
  double noise;
  DsbrdfShape shape;
};

TEST(Ceres, FindsTheSameMinimum) {
  for (const Case& c : {Case{1e9, 0.02, {2, 5}}, Case{1.0, 0.02, {2, 5}}, Case{1.0, 0.1, {1, 4}},
                        Case{1.5, 0.01, {3, 7}}}) {
    const Dsbrdf truth = SyntheticMaterial(1, c.shape);
    const std::vector<BrdfSample> samples = Readings(truth, 120, c.noise, 2);
    const Prior prior = GenericPrior(c.shape);
    FitOptions options;
    options.huber = c.huber;
    options.tolerance = 1e-13;
    options.max_iterations = 500;
    constexpr double kModelError = 0.02;
    const DsbrdfFit ours = RefitDsbrdf(samples, prior, options, truth.parameters(), kModelError);
    const PosteriorOptions same{options.floor, options.huber, kModelError};
    const CeresMinimum theirs =
        MinimiseWithCeres(samples, prior, same, truth.parameters(), 500, 1e-13);
    EXPECT_TRUE(ours.summary().converged);
    EXPECT_TRUE(theirs.converged);
    EXPECT_NEAR(ours.summary().cost, theirs.cost, 1e-6 * theirs.cost) << c.shape.lobes << " lobes";
    const Posterior posterior(samples, prior, same);
    EXPECT_NEAR(posterior.Cost(theirs.parameters), theirs.cost, 1e-9 * theirs.cost);
    for (const BrdfSample& sample : samples) {
      const Rgb f = *ours.Eval(sample.directions);
      const Rgb g = *Dsbrdf(c.shape, theirs.parameters).Eval(sample.directions);
      EXPECT_LT(((f - g) / f).abs().maxCoeff(), 1e-3);
    }
  }
}

}  // namespace
}  // namespace gonio
