// SPDX-License-Identifier: Apache-2.0
// All lobes of a slice fitted together, and each slice with an eye on its neighbours.

#pragma once

#include <span>
#include <vector>

#include "fitting/slice_fit.h"

namespace gonio {

struct JointOptions {
  int lobes = 3;       // 1 .. kMaxLobes
  double floor = 0.2;  // 1/sr, > 0: f_r cos theta_i below this counts absolutely, above relatively
  double model_error =
      0.015;  // > 0: spread of ln(1 + f cos theta_i / floor) that lobes are not to explain
  double coupling = 0.5;  // > 0: how much log kappa and log gamma may differ between neighbours
  double huber = 1;       // > 0: residuals beyond this many model errors count linearly
  int sweeps = 20;  // >= 0: at most so many passes over the slices after each has been fitted alone
};

// Fits the slices of one channel, in order of theta_d. Minimises
//
//   sum_i sum_n w_in rho(r_in / model_error)
//     + 1/2 sum_i |(log kappa, log gamma)_i - (log kappa, log gamma)_{i+1}|^2 / coupling^2
//   r_in = ln(1 + c_in L_in / floor) - ln(1 + c_in f_i(theta_in) / floor)
//
// over log kappa and log gamma of all lobes: what people see (a cosine-weighted logarithm) instead
// of the peak alone, rho being Huber's loss made smooth. The headline metric has a floor of 1, but
// then dark metals lose the colour of their dim parts. c_in is the mean cosine of the point, w_in
// the range of theta_h and the number of phi_d it stands for, 1 on average. Each slice is first
// fitted alone from several widths of the narrow lobes; then, sweep by sweep, again from where it
// and its neighbours stand, its neighbours held: block coordinate descent, so that lobe k of one
// slice continues lobe k of the one before.
//
// A SliceFit's cost is its share of the sum; lobes are in order of gamma at the first slice.
// Precondition: theta_h ascends and !WhyNotFittable() in each slice.
std::vector<SliceFit> FitSlicesJoint(std::span<const std::vector<SlicePoint>> slices,
                                     const JointOptions& options = {});

}  // namespace gonio
