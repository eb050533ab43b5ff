// SPDX-License-Identifier: Apache-2.0
#include "fitting/levenberg_marquardt.h"

#include <gtest/gtest.h>

namespace gonio {
namespace {

// Rosenbrock's valley as a sum of squares: minimum 0 at (1, 1).
struct Valley {
  mutable int calls = 0;

  double Linearise(const Eigen::Vector2d& at, Eigen::Vector2d* gradient,
                   Eigen::Matrix2d* hessian) const {
    ++calls;
    const Eigen::Vector2d residuals(10 * (at[1] - at[0] * at[0]), 1 - at[0]);
    Eigen::Matrix2d jacobian;
    jacobian << -20 * at[0], 10, -1, 0;
    *gradient = jacobian.transpose() * residuals;
    *hessian = jacobian.transpose() * jacobian;
    return residuals.squaredNorm() / 2;
  }
};

TEST(Minimise, FollowsRosenbrocksValley) {
  const auto minimum = Minimise(Valley{}, Eigen::Vector2d(-1.2, 1), 200, 1e-12);
  EXPECT_TRUE(minimum.converged);
  EXPECT_LT(minimum.cost, 1e-12);
  EXPECT_NEAR(minimum.parameters[0], 1, 1e-5);
  EXPECT_NEAR(minimum.parameters[1], 1, 1e-5);
}

TEST(Minimise, GivesTheHessianOfWhereItEnded) {
  const Valley valley;
  const auto minimum = Minimise(valley, Eigen::Vector2d(-1.2, 1), 200, 1e-12);
  Eigen::Vector2d gradient;
  Eigen::Matrix2d hessian;
  EXPECT_EQ(valley.Linearise(minimum.parameters, &gradient, &hessian), minimum.cost);
  EXPECT_EQ(hessian, minimum.hessian);
}

TEST(Minimise, EndsAtTheLimitAndSaysSo) {
  const Valley valley;
  const auto minimum = Minimise(valley, Eigen::Vector2d(-1.2, 1), 3, 1e-12);
  EXPECT_FALSE(minimum.converged);
  EXPECT_EQ(minimum.iterations, 3);
  EXPECT_EQ(valley.calls, 4);
}

// Cost() is what steps are tried with, where there is one; it changes nothing else.
struct ValleyWithCost : Valley {
  mutable int costs = 0;

  double Cost(const Eigen::Vector2d& at) const {
    ++costs;
    return 50 * std::pow(at[1] - at[0] * at[0], 2) + std::pow(1 - at[0], 2) / 2;
  }
};

TEST(Minimise, TriesStepsWithTheCostAloneIfItCan) {
  const Valley valley;
  const ValleyWithCost cheaper;
  const auto one = Minimise(valley, Eigen::Vector2d(-1.2, 1), 200, 1e-12);
  const auto other = Minimise(cheaper, Eigen::Vector2d(-1.2, 1), 200, 1e-12);
  EXPECT_EQ(cheaper.costs, other.iterations);
  EXPECT_LT(cheaper.calls, valley.calls);
  EXPECT_NEAR(one.parameters[0], other.parameters[0], 1e-6);
}

// Nothing depends on the second parameter, and what is not a number costs nothing.
struct Trap {
  double Linearise(const Eigen::Vector2d& at, Eigen::Vector2d* gradient,
                   Eigen::Matrix2d* hessian) const {
    *gradient = {at[0] - 2, 0};
    *hessian = Eigen::Vector2d(1, 0).asDiagonal();
    return at.allFinite() ? 1 + std::pow(at[0] - 2, 2) / 2 : 0;
  }
};

TEST(Minimise, LeavesAParameterThatDoesNotMatterWhereItIs) {
  const auto minimum = Minimise(Trap{}, Eigen::Vector2d(-1, 7), 50, 1e-12);
  EXPECT_TRUE(minimum.converged);
  EXPECT_NEAR(minimum.parameters[0], 2, 1e-5);
  EXPECT_EQ(minimum.parameters[1], 7);
}

}  // namespace
}  // namespace gonio
