// SPDX-License-Identifier: Apache-2.0
// The poses a planner may choose from.

#pragma once

#include <functional>
#include <vector>

#include "brdf/direction.h"

namespace gonio {

// One pose that may be measured, and where it stands in the raster it came from.
struct Candidate {
  HalfDiff angles;
  DirectionPair directions;
  int row = 0;           // theta_h index
  int column = 0;        // theta_d index
  double cell_area = 0;  // theta_h width x theta_d width of the raster cell [rad^2]
};

// Which phi_d a cell of the raster is measured at. A DSBRDF does not depend on phi_d, a material
// may.
enum class PhiChoice {
  kAcross,   // 90 degrees everywhere: the two directions mirror each other across the half vector's
             // plane of tilt; inside the horizon for every theta_h, theta_d
  kSpread,   // a low-discrepancy sequence around 90 degrees, so that neighbours differ: a fit
             // then averages over phi_d; cells without room keep to where both polar angles are
             // small enough
  kInPlane,  // 0 degrees, the light farther from the normal than the detector; where that cannot be
             // reached, 180, the two exchanged, which is the same by reciprocity. For rigs that
             // reach nothing else; theta_h + theta_d < 90 degrees is all that they can
};

struct CandidateOptions {
  int theta_h_count = 90;    // rows, 1 .. 1000
  int theta_d_count = 90;    // columns, 1 .. 1000
  bool merl_spacing = true;  // rows dense towards theta_h = 0, as in a MERL table; else uniform
  PhiChoice phi = PhiChoice::kSpread;
  int phi_choices = 1;  // 1 .. 12: so many phi_d for each cell, evenly over phi_span (kSpread)
  double phi_span = 1.5707963;   // rad (90 deg), 0 .. pi: width of the range around 90 deg that
                                 // kSpread uses
  double max_polar = 1.4137167;  // rad (81 deg): spread phi_d keeps both directions within this
};

using Reachable = std::function<bool(const DirectionPair&)>;

// The raster of theta_h x theta_d cell centres, in raster order (row by row), without the poses
// below the horizon and those `reachable` refuses (an empty function refuses none).
std::vector<Candidate> MakeCandidates(const CandidateOptions& options, const Reachable& reachable);

// Index of the candidate nearest to (theta_h, theta_d) [rad] on the unit square of
// (sqrt(theta_h / 90 deg), theta_d / 90 deg); -1 if none.
int NearestCandidate(const std::vector<Candidate>& candidates, double theta_h, double theta_d);

}  // namespace gonio
