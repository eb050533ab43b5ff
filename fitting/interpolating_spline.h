// SPDX-License-Identifier: Apache-2.0
// Curves through given points.

#pragma once

#include <vector>

namespace gonio {

enum class SplineKind {
  kNatural,   // twice continuously differentiable, straight at the ends; may overshoot
  kMonotone,  // once; nowhere beyond the two points it lies between (Fritsch & Butland, SIAM J.
              // Sci. Stat. Comput. 5(2), 1984)
};

// A piecewise cubic through (x_i, y_i), constant beyond the first and the last point.
class InterpolatingSpline {
 public:
  // Precondition: as many y as x, at least one, x ascending.
  InterpolatingSpline(std::vector<double> x, std::vector<double> y, SplineKind kind);
  double operator()(double x) const;

 private:
  std::vector<double> x_, y_;
  std::vector<double> slope_;  // at each point
};

}  // namespace gonio
