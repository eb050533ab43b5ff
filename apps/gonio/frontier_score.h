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
// kIntervals. The directions are those the metrics look at with these strides, weighted uniform in
// angle, both polar angles below 80 degrees; those whose cell holds a sample are left out. NaN if
// no direction is left.
std::array<double, kIntervals.size()> Coverage(const Brdf& truth, const Estimate& estimate,
                                               std::span<const BrdfSample> samples,
                                               int theta_d_stride, int phi_stride);

// Fills in the metrics, and the coverage if `reconstruction` is an Estimate. Intervals are dear, so
// that their strides are four times (theta_d) and three times (phi_d) those of the metrics.
void Score(const Brdf& truth, const Brdf& reconstruction, std::span<const BrdfSample> samples,
           const FrontierConfig& study, FrontierRow* row);

}  // namespace gonio
