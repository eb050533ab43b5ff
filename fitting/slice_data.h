// SPDX-License-Identifier: Apache-2.0
// The slices of a reflectance that published DSBRDF fits start from: f_r against theta_h at fixed
// theta_d, averaged over phi_d.

#pragma once

#include <span>
#include <vector>

#include "brdf/brdf.h"
#include "core/units.h"

namespace gonio {

// One theta_h of a slice.
struct SlicePoint {
  double theta_h = 0;  // rad
  double width = 0;    // rad: the range of theta_h it stands for in the full table; 0: unknown
  // Means over the phi_d at which both directions are above the horizon and f_r is known:
  double f_r = 0;          // 1/sr
  double cos_theta_i = 0;  // their mean
  int cells = 0;           // how many phi_d; 0: nothing known here, the means are 0
};

struct SliceData {
  double theta_d = 0;  // rad
  // Per channel; the same theta_h in each, ascending.
  std::vector<SlicePoint> points[kChannels];
};

struct SliceOptions {
  double step =
      RadFromDeg(5);   // rad, 1 .. 30 deg: between slices, which begin at theta_d = 0.5 deg
  int keep_every = 1;  // keep theta_h 0, n, 2n, ... of the 90: the paper's thinning; 1 .. 90
  int phi_stride = 1;  // average over every n-th phi_d cell, 1 .. 180

  // Throws ConfigError naming the option.
  void Check() const;
};

// Slices at the centres of MERL cells (brdf/merl_table.h) nearest to multiples of the step, asked
// of a reflectance that is known everywhere.
std::vector<SliceData> SlicesOf(const Brdf& brdf, const SliceOptions& options);
// One slice of it.
SliceData SliceAt(const Brdf& brdf, int theta_d_cell, const SliceOptions& options);

// Scattered samples put into the slices they are nearest to, which are at multiples of the step;
// each is a point of its own. Slices without samples are left out. Throws ConfigError if keep_every
// is not 1.
std::vector<SliceData> SlicesOf(std::span<const BrdfSample> samples, const SliceOptions& options);

}  // namespace gonio
