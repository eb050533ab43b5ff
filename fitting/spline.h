// SPDX-License-Identifier: Apache-2.0
// Uniform cubic B-splines.

#pragma once

#include <array>

namespace gonio {

// The four spline coefficients that matter at one place, and their weights:
// s = sum_j weight[j] * coefficient[first + j]. Weights are >= 0 and sum to 1.
struct SplineBasis {
  int first = 0;
  std::array<double, 4> weight{};
};

// Cubic B-spline basis with `knots` >= 4 coefficients on uniform knots over [0, 1], twice
// continuously differentiable (C. de Boor, "A Practical Guide to Splines", 1978). x outside is
// clamped.
SplineBasis UnitBasisAt(double x, int knots);

// The same over theta_d in [0, pi/2].
SplineBasis BasisAt(double theta_d, int knots);

// Where coefficient j pulls most: the theta_d of its basis function's peak [rad]. May lie outside
// [0, pi/2] by one knot distance.
double KnotPosition(int j, int knots);

}  // namespace gonio
