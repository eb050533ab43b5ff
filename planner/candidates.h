// SPDX-License-Identifier: Apache-2.0
// The poses a planner may choose from.

#pragma once

#include <functional>
#include <vector>

#include "brdf/direction.h"

namespace gonio {

// One pose that may be measured, where it stands in the raster it came from.
struct Candidate {
  HalfDiff angles;
  DirectionPair directions;
  int row = 0;     // theta_h index
  int column = 0;  // theta_d index
};

struct CandidateOptions {
  int theta_h_count = 90;  // rows
  int theta_d_count = 90;  // columns
  // "merl": rows at the centres of MERL's cells, dense towards theta_h = 0; "uniform".
  bool merl_spacing = true;
};

using Reachable = std::function<bool(const DirectionPair&)>;

// The raster of theta_h x theta_d cell centres, in raster order (row by row), without the poses
// below the horizon and those `reachable` refuses (an empty function refuses none).
std::vector<Candidate> MakeCandidates(const CandidateOptions& options, const Reachable& reachable);

}  // namespace gonio
