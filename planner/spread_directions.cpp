// SPDX-License-Identifier: Apache-2.0
#include "planner/spread_directions.h"

#include <cmath>

#include "core/check.h"
#include "core/units.h"

namespace gonio {
namespace {

// n's digits to this base, mirrored at the point: 0 .. 1.
double RadicalInverse(int n, int base) {
  double inverse = 0;
  for (double digit = 1.0 / base; n > 0; n /= base, digit /= base) inverse += digit * (n % base);
  return inverse;
}

}  // namespace

std::vector<SpreadDirection> SpreadDirections(int count, double max_polar) {
  GONIO_CHECK(count > 0 && max_polar > 0, "directions to spread");
  const double limit = std::cos(max_polar);
  std::vector<SpreadDirection> directions;
  double sum = 0;
  for (int n = 1; static_cast<int>(directions.size()) < count; ++n) {
    const double u = RadicalInverse(n, 2);
    const HalfDiff angles{u * u * kPi / 2, RadicalInverse(n, 3) * kPi / 2,
                          RadicalInverse(n, 5) * kPi};
    double cos_i = 0;
    double cos_o = 0;
    Cosines(angles, &cos_i, &cos_o);
    if (cos_i < limit || cos_o < limit) continue;
    directions.push_back({angles, cos_i, u});
    sum += u;
  }
  for (SpreadDirection& direction : directions) direction.weight /= sum;
  return directions;
}

}  // namespace gonio
