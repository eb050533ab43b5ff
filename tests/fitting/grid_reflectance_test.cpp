// SPDX-License-Identifier: Apache-2.0
#include "fitting/grid_reflectance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/fitting/training_set.h"

namespace gonio {
namespace {

TEST(GridReflectance, RepeatsItsNodesAndIsStraightInTheLogarithmBetween) {
  const AngleGrid grid(20, 10, 1);
  const auto material = PeakedMaterial(0.1, 5, 0.3);
  const GridReflectance brdf("x", grid, SampleOnGrid(*material, grid));
  const HalfDiff low = grid.Node(grid.Index(4, 3, 0));
  const HalfDiff high = grid.Node(grid.Index(5, 3, 0));
  const double f_low = (*material->Eval(low))[0];
  const double f_high = (*material->Eval(high))[0];
  EXPECT_NEAR((*brdf.Eval(low))[0], f_low, 1e-4);
  HalfDiff between = low;
  between.theta_h = std::pow((std::sqrt(low.theta_h) + std::sqrt(high.theta_h)) / 2, 2);
  EXPECT_NEAR((*brdf.Eval(between))[0], std::sqrt((f_low + 1e-3) * (f_high + 1e-3)) - 1e-3, 1e-4);
  EXPECT_EQ(brdf.name(), "x");
}

TEST(GridReflectance, IsEmptyBelowTheHorizonAndNeverNegative) {
  const AngleGrid grid(4, 4, 2);
  const GridReflectance brdf("black", grid, Eigen::Matrix3Xf::Zero(3, grid.size()));
  EXPECT_FALSE(brdf.Eval(HalfDiff{1.4, 1.4, 0}).has_value());
  EXPECT_TRUE((*brdf.Eval(HalfDiff{0.3, 0.4, 0.5}) >= 0).all());
  EXPECT_LT(brdf.Eval(HalfDiff{0.3, 0.4, 0.5})->maxCoeff(), 1e-9);
}

}  // namespace
}  // namespace gonio
