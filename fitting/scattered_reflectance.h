// SPDX-License-Identifier: Apache-2.0
// Reflectance interpolated between scattered samples, with no model and no database.

#pragma once

#include <memory>
#include <span>

#include "brdf/brdf.h"

namespace gonio {

struct ScatteredOptions {
  double floor = 0.01;   // 1/sr, > 0: what is interpolated is ln(f_r + floor)
  double stretch = 0.5;  // > 0: a step across theta_d counts this much of one across sqrt(theta_h)
  double smoothing = 1;  // >= 0: 0 passes through the readings, 1 trusts their sigma
};

// Interpolates each channel's ln(f_r + floor) over (sqrt(theta_h), theta_d) with a radial basis,
// the distance itself, plus a constant:
//
//   s(x) = a + sum_n w_n |x - x_n|,   sum_n w_n = 0
//
// the two-dimensional relative of linear interpolation, which neither overshoots at a peak's edge
// nor runs away beyond the samples as thin plates do (kernels: R. Schaback, H. Wendland, "Kernel
// techniques", 2006). phi_d is ignored: reflectance hardly depends on it. Readings are smoothed by
// their sigma; those of infinite sigma are left out, and negative ones count as 0. The result stays
// within the range of the readings and has a value wherever both directions are above the horizon
// (0 in a channel without readings).
//
// n samples cost n^3; meant for up to about a thousand. Evaluating costs about 0.1 us: the
// interpolant is laid down on a grid as dense as a MERL table.
std::unique_ptr<Brdf> InterpolateScattered(std::span<const BrdfSample> samples,
                                           const ScatteredOptions& options = {});

}  // namespace gonio
