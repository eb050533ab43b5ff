// SPDX-License-Identifier: Apache-2.0
#include "fitting/spline.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace gonio {

SplineBasis UnitBasisAt(double x, int knots) {
  const int intervals = knots - 3;
  const double scaled = std::clamp(x, 0.0, 1.0) * intervals;
  const int first = std::min(static_cast<int>(scaled), intervals - 1);
  const double t = scaled - first;
  const double s = 1 - t;
  return {first,
          {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6,
           t * t * t / 6}};
}

SplineBasis BasisAt(double theta_d, int knots) { return UnitBasisAt(theta_d / (kPi / 2), knots); }

double KnotPosition(int j, int knots) { return (j - 1) * (kPi / 2) / (knots - 3); }

}  // namespace gonio
