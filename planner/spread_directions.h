// SPDX-License-Identifier: Apache-2.0
// Directions that stand for all of them.

#pragma once

#include <vector>

#include "brdf/direction.h"

namespace gonio {

struct SpreadDirection {
  HalfDiff angles;
  double cosine = 0;  // of theta_i
  double weight = 0;  // all sum to 1
};

// `count` directions with both ends within max_polar [rad] of the normal: Halton's points (J.
// Halton, Numer. Math. 2, 1960), as dense as sqrt(theta_h), each weighted with as much of theta_h
// as it stands for. No two of their coordinates follow each other, not even in the highlight alone;
// other sequences of low discrepancy stand on lines there, and a planner then looks along those
// lines only. Precondition: count > 0.
std::vector<SpreadDirection> SpreadDirections(int count, double max_polar);

}  // namespace gonio
