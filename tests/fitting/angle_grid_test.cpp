// SPDX-License-Identifier: Apache-2.0
#include "fitting/angle_grid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/units.h"
#include "sim/random.h"
#include "tests/brdf/function_brdf.h"

namespace gonio {
namespace {

double Interpolate(const AngleGrid& grid, const Eigen::MatrixXf& f_r, const HalfDiff& angles) {
  double sum = 0;
  for (const AngleGrid::Corner& corner : grid.Locate(angles)) {
    sum += corner.weight * f_r(0, corner.index);
  }
  return sum;
}

TEST(AngleGrid, HasNodesAtBothEndsAndMostAtTheMirrorDirection) {
  const AngleGrid grid(10, 7, 6);
  EXPECT_EQ(grid.size(), 420);
  EXPECT_EQ(grid.Node(0).theta_h, 0);
  const HalfDiff last = grid.Node(grid.Index(9, 6, 5));
  EXPECT_NEAR(last.theta_h, kPi / 2, 1e-12);
  EXPECT_NEAR(last.theta_d, kPi / 2, 1e-12);
  EXPECT_NEAR(last.phi_d, kPi * 5 / 6, 1e-12);
  EXPECT_NEAR(grid.Node(grid.Index(3, 0, 0)).theta_h, kPi / 2 / 9, 1e-12);
}

TEST(AngleGrid, LocatesANodeAtItself) {
  const AngleGrid grid(9, 5, 4);
  for (int i = 0; i < grid.size(); ++i) {
    double weight = 0;
    for (const auto& corner : grid.Locate(grid.Node(i))) {
      if (corner.index == i) weight += corner.weight;
    }
    EXPECT_NEAR(weight, 1, 1e-9) << i;
  }
}

TEST(AngleGrid, WeightsSumToOneWhateverTheAngles) {
  const AngleGrid grid(9, 5, 4);
  for (const HalfDiff angles :
       {HalfDiff{0, 0, 0}, HalfDiff{2, 2, kPi}, HalfDiff{-0.1, 0.3, -0.01}, HalfDiff{1, 1, 7}}) {
    double sum = 0;
    for (const auto& corner : grid.Locate(angles)) {
      EXPECT_GE(corner.index, 0);
      EXPECT_LT(corner.index, grid.size());
      EXPECT_GE(corner.weight, 0);
      sum += corner.weight;
    }
    EXPECT_NEAR(sum, 1, 1e-12);
  }
}

TEST(AngleGrid, IsLinearInTheRootOfThetaHAndInThetaDAndPeriodicInPhiD) {
  const AngleGrid grid(12, 8, 8);
  Eigen::MatrixXf f_r(1, grid.size());
  const auto shape = [](const HalfDiff& a) {
    return 2 + 3 * std::sqrt(a.theta_h) - 0.5 * a.theta_d + std::abs(a.phi_d - kPi / 2);
  };
  for (int i = 0; i < grid.size(); ++i) f_r(0, i) = static_cast<float>(shape(grid.Node(i)));
  Random random(1, 0);
  for (int n = 0; n < 200; ++n) {
    const HalfDiff angles{random.Uniform() * kPi / 2, random.Uniform() * kPi / 2,
                          random.Uniform() * kPi};
    EXPECT_NEAR(Interpolate(grid, f_r, angles), shape(angles), 1e-5);
  }
}

TEST(AngleGrid, CallsNodesBelowTheHorizonUnphysical) {
  const AngleGrid grid(10, 10, 4);
  EXPECT_TRUE(grid.Physical(grid.Index(0, 9, 0)));   // mirror direction, nearly grazing
  EXPECT_TRUE(grid.Physical(grid.Index(9, 0, 0)));   // light and detector together, nearly grazing
  EXPECT_FALSE(grid.Physical(grid.Index(9, 5, 0)));  // one of them below
  EXPECT_TRUE(grid.Physical(grid.Index(9, 5, 2)));   // phi_d = 90 deg: both just above
}

TEST(SampleOnGrid, RepeatsTheNearestKnownNodeAlongThetaHBelowTheHorizon) {
  const AngleGrid grid(10, 10, 4);
  const FunctionBrdf brdf([](const HalfDiff& a) { return Rgb::Constant(1 + a.theta_h); });
  const Eigen::MatrixXf f_r = SampleOnGrid(brdf, grid);
  int last = 0;
  while (grid.Physical(grid.Index(last + 1, 5, 0))) ++last;
  EXPECT_NEAR(f_r(1, grid.Index(last, 5, 0)), 1 + grid.Node(grid.Index(last, 5, 0)).theta_h, 1e-5);
  for (int h = last; h < 10; ++h) {
    EXPECT_EQ(f_r(1, grid.Index(h, 5, 0)), f_r(1, grid.Index(last, 5, 0)));
  }
}

TEST(SampleOnGrid, FillsWhereNothingOrSomethingNegativeIsKnown) {
  const AngleGrid grid(10, 10, 4);
  const FunctionBrdf brdf([](const HalfDiff& a) -> std::optional<Rgb> {
    if (a.theta_d > 1.2) return std::nullopt;
    if (a.theta_h < 0.1) return Rgb(1, -1, 1);
    return Rgb::Constant(0.5 + a.theta_d);
  });
  const Eigen::MatrixXf f_r = SampleOnGrid(brdf, grid);
  EXPECT_TRUE((f_r.array() >= 0.5).all());
  EXPECT_NEAR(f_r(0, grid.Index(0, 3, 1)), 0.5 + kPi / 6, 1e-5);
  EXPECT_NEAR(f_r(0, grid.Index(3, 9, 1)), 0.5 + kPi / 2 * 6 / 9, 1e-5);  // the last known theta_d
}

TEST(SampleOnGrid, RefusesAReflectanceThatKnowsNothing) {
  const FunctionBrdf brdf([](const HalfDiff&) -> std::optional<Rgb> { return std::nullopt; });
  EXPECT_THROW(SampleOnGrid(brdf, AngleGrid(4, 4, 2)), ConfigError);
}

}  // namespace
}  // namespace gonio
