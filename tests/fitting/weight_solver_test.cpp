// SPDX-License-Identifier: Apache-2.0
#include "fitting/weight_solver.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "sim/random.h"

namespace gonio {
namespace {

constexpr double kStrength = 0.7;
constexpr int kWeights = 6;
constexpr int kLearned = 2;

Eigen::MatrixXd RandomMatrix(int rows, int columns, Random& random) {
  Eigen::MatrixXd matrix(rows, columns);
  for (double& number : matrix.reshaped()) number = random.Normal();
  return matrix;
}

Eigen::MatrixXd PriorCovariance() {
  Eigen::VectorXd variances = Eigen::VectorXd::Ones(kWeights);
  variances.tail(kWeights - kLearned).setConstant(kStrength * kStrength);
  return variances.asDiagonal();
}

// Fewer readings than weights, as many, and more: solved in different ways.
class Solved : public testing::TestWithParam<int> {};

// Against the textbook's formulas, inverses and all.
TEST_P(Solved, IsTheGaussianPosterior) {
  Random random(3, 0);
  const Eigen::MatrixXd features = RandomMatrix(kWeights, GetParam(), random);
  const Eigen::MatrixXd values = RandomMatrix(GetParam(), 2, random);
  const Eigen::MatrixXd prior = PriorCovariance();
  Eigen::MatrixXd covariance = features.transpose() * prior * features;
  covariance.diagonal().array() += 1;
  const Eigen::MatrixXd gain = prior * features * covariance.inverse();

  WeightSolver solver(features, values, kLearned);
  solver.Solve(3);  // of which nothing must stay behind
  solver.Solve(kStrength);
  EXPECT_NEAR(solver.log_determinant(), std::log(covariance.determinant()), 1e-9);
  EXPECT_NEAR(solver.quadratic(), (values.transpose() * covariance.inverse() * values).trace(),
              1e-9);
  EXPECT_TRUE(solver.Mean().isApprox(gain * values, 1e-9));
  EXPECT_TRUE(solver.Covariance().isApprox(prior - gain * features.transpose() * prior, 1e-9));
}

INSTANTIATE_TEST_SUITE_P(WeightSolver, Solved, testing::Values(1, 5, 6, 9),
                         testing::PrintToStringParamName());

TEST(WeightSolver, KnowsThePriorOnlyWithoutReadings) {
  WeightSolver solver(Eigen::MatrixXd(kWeights, 0), Eigen::MatrixXd(0, 1), kLearned);
  solver.Solve(kStrength);
  EXPECT_EQ(solver.log_determinant(), 0);
  EXPECT_EQ(solver.quadratic(), 0);
  EXPECT_EQ(solver.Mean(), Eigen::MatrixXd::Zero(kWeights, 1));
  EXPECT_EQ(solver.Covariance(), PriorCovariance());
}

}  // namespace
}  // namespace gonio
