// SPDX-License-Identifier: Apache-2.0
#include "fitting/process_material.h"

#include <gtest/gtest.h>

#include "fitting/process_fit.h"
#include "tests/fitting/small_process.h"

namespace gonio {
namespace {

std::array<Eigen::VectorXd, kChannels> Weights(const ProcessModel& model, double value) {
  std::array<Eigen::VectorXd, kChannels> weights;
  for (const ProcessModel::Group& group : model.groups()) {
    for (int s = group.first_series; s < group.first_series + group.series; ++s) {
      weights[s].setConstant(group.size, value);
    }
  }
  return weights;
}

TEST(ProcessMaterial, IsTheProcessWithTheseWeights) {
  const auto model = std::make_shared<const ProcessModel>(*SmallProcessPrior().process);
  const ProcessMaterial mean(model, Weights(*model, 0), "mean");
  const ProcessMaterial other(model, Weights(*model, 0.3), "other");
  const HalfDiff angles{0.2, 0.5, 1.2};
  const auto at_mean = mean.Eval(angles);
  ASSERT_TRUE(at_mean.has_value());
  // Luminance alone has a mean: the mean material is grey.
  EXPECT_NEAR((*at_mean)[0], (*at_mean)[2], 1e-9);
  EXPECT_GT((*at_mean)[0], 0);
  EXPECT_GT((*other.Eval(angles) - *at_mean).abs().maxCoeff(), 1e-4);
  EXPECT_EQ(mean.name(), "mean");
}

TEST(ProcessMaterial, IsNothingBelowTheHorizonAndNeverNegative) {
  const auto model = std::make_shared<const ProcessModel>(*SmallProcessPrior().process);
  const ProcessMaterial dark(model, Weights(*model, -5), "dark");
  EXPECT_FALSE(dark.Eval(HalfDiff{1.5, 1.5, 0}).has_value());
  for (double theta_h = 0; theta_h < 1.2; theta_h += 0.1) {
    const auto f_r = dark.Eval(HalfDiff{theta_h, 0.1, 1.5});
    ASSERT_TRUE(f_r.has_value()) << theta_h;
    EXPECT_GE(f_r->minCoeff(), 0) << theta_h;
  }
}

}  // namespace
}  // namespace gonio
