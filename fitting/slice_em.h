// SPDX-License-Identifier: Apache-2.0
// One slice fitted as published: Algorithm 1 of Edahiro, Nagahara & Taniguchi, "Redundancy of BRDF
// studied with DSBRDF".

#pragma once

#include <span>

#include "fitting/slice_fit.h"

namespace gonio {

struct EmOptions {
  int lobes = 3;             // 1 .. kMaxLobes
  int max_iterations = 100;  // of E- and M-step, > 0
  double tolerance = 1e-3;   // > 0: ended when no log kappa, log gamma moves by more
};

// Expectation maximisation on readings L_n at theta_h,n:
//
//   E-step   q_nk = p(theta_n | kappa_k, gamma_k) / sum_j p(theta_n | kappa_j, gamma_j)
//   M-step   min over kappa_k, gamma_k of  sum_n (q_nk L_n - (exp(kappa_k cos^gamma_k theta_n) -
//   1))^2
//
// with the normalised density p of fitting/hemi_epd.h: lobe k is fitted, by Levenberg-Marquardt
// (Ceres), to the share of each reading that it is held responsible for. Where the printed
// algorithm says nothing we do this: start from StartingLobes() with gamma up to 200, the same in
// each slice; lobes keep the index they started with; log kappa and log gamma are what is iterated,
// within bounds that materials do not reach.
//
// docs/paper.md shows what this reading does: it is not a descent. As each lobe is normalised, the
// narrow one is held responsible for the peak however little of the light it carries, and the
// iteration settles where shares and densities agree, not where the sum of squares is least.
//
// The cost of the result is sum_n (L_n - f(theta_n))^2 [1/sr^2]. Precondition: theta_h ascends,
// !WhyNotFittable().
SliceFit FitSliceEm(std::span<const SlicePoint> points, const EmOptions& options = {});

}  // namespace gonio
