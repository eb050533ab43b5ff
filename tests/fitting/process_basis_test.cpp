// SPDX-License-Identifier: Apache-2.0
#include "fitting/process_basis.h"

#include <gtest/gtest.h>

#include "core/units.h"
#include "sim/random.h"

namespace gonio {
namespace {

HalfDiff RandomAngles(Random& random) {
  return {random.Uniform() * kPi / 2, random.Uniform() * kPi / 2, random.Uniform() * kPi};
}

TEST(ProcessBasis, HoldsConstants) {
  const ProcessBasis basis(9, 6);
  Eigen::VectorXd constant = Eigen::VectorXd::Zero(basis.size());
  for (int i = 0; i < basis.size(); i += ProcessBasis::kHarmonics) constant[i] = 3;
  Random random(1, 0);
  for (int n = 0; n < 50; ++n) {
    EXPECT_NEAR(basis.At(RandomAngles(random)).Of(constant), 3, 1e-12);
  }
}

TEST(ProcessBasis, ForgetsPhiWherePhiMeansNothing) {
  const ProcessBasis basis(9, 6);
  Random random(2, 0);
  Eigen::VectorXd c(basis.size());
  for (double& x : c) x = random.Normal();
  EXPECT_NEAR(basis.At({0, 0.7, 0.3}).Of(c), basis.At({0, 0.7, 2.1}).Of(c), 1e-12);
  EXPECT_NEAR(basis.At({0.7, 0, 0.3}).Of(c), basis.At({0.7, 0, 2.1}).Of(c), 1e-12);
  EXPECT_GT(std::abs(basis.At({0.7, 0.7, 0.3}).Of(c) - basis.At({0.7, 0.7, 2.1}).Of(c)), 1e-3);
}

TEST(ProcessBasis, GivesRowsOfFeaturesColumnByColumn) {
  const ProcessBasis basis(8, 5);
  Random random(3, 0);
  Eigen::MatrixXd c(basis.size(), 3);
  for (double& x : c.reshaped()) x = random.Normal();
  for (int n = 0; n < 20; ++n) {
    const ProcessBasis::Terms terms = basis.At(RandomAngles(random));
    const Eigen::VectorXd row = terms.RowOf(c);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(row[k], terms.Of(c.col(k)), 1e-12);
  }
}

}  // namespace
}  // namespace gonio
