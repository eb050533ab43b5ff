// SPDX-License-Identifier: Apache-2.0
// What the two ways of fitting one slice have in common.

#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fitting/lobe_model.h"
#include "fitting/slice_data.h"

namespace gonio {

// Lobes of one slice and channel.
struct SliceFit {
  std::vector<Lobe> lobes;
  int iterations = 0;
  bool converged = false;
  double cost = 0;     // what the method minimises
  std::string reason;  // why the iteration ended
};

// Why `lobes` lobes cannot be fitted to these points, in words; empty if they can. No reading at
// all, none valid, fewer than the 2 x lobes parameters, all zero, or negative beyond what noise and
// colours out of gamut make: below -5 % of the largest.
std::optional<std::string> WhyNotFittable(std::span<const SlicePoint> points, int lobes);

// Whether all readings are alike to 1e-6: one lobe says it all and the others are arbitrary.
bool IsConstant(std::span<const SlicePoint> points);

// Where iterations start: lobes from broad to narrow, gamma spaced geometrically from 0.5 to
// `narrowest`. The broad one has the level of the readings beyond 30 deg, the narrowest the height
// of the largest reading, those between heights in geometric order.
std::vector<Lobe> StartingLobes(std::span<const SlicePoint> points, int lobes, double narrowest);

}  // namespace gonio
