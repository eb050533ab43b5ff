// SPDX-License-Identifier: Apache-2.0
// How good a reconstruction is, and how well it knows.

#pragma once

#include <array>
#include <span>

#include "apps/gonio/frontier_config.h"
#include "apps/gonio/frontier_result.h"
#include "fitting/estimate.h"

namespace gonio {

// Share of the channels of all directions at which the true f_r lies in the interval of each of
// kIntervals. The directions are every `theta_stride`-th theta_h and theta_d and every
// `phi_stride`-th phi_d of a MERL table, weighted uniform in angle, both polar angles below 80
// degrees; those whose cell holds a sample are left out. NaN if no direction is left.
std::array<double, kIntervals.size()> Coverage(const Brdf& truth, const Estimate& estimate,
                                               std::span<const BrdfSample> samples,
                                               int theta_stride, int phi_stride);

// Fills in the metrics, and the coverage if `reconstruction` is an Estimate. Intervals are dear, so
// that their directions are twice as far apart as those of the metrics, in each angle.
void Score(const Brdf& truth, const Brdf& reconstruction, std::span<const BrdfSample> samples,
           const FrontierConfig& study, FrontierRow* row);

}  // namespace gonio
