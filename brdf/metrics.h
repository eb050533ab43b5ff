// SPDX-License-Identifier: Apache-2.0
// How far one reflectance is from another, over the cells of a MERL table.

#pragma once

#include <vector>

#include "brdf/brdf.h"
#include "core/units.h"

namespace gonio {

struct MetricOptions {
  // Cells count only if theta_i and theta_o are both below this [rad], 0 < max_theta <= pi/2:
  // beyond 80 deg tables are extrapolated.
  double max_theta = RadFromDeg(80);
  int phi_stride = 1;  // look at every n-th phi_d cell only, 1 .. 180; studies take 4
  // The same for theta_d, 1 .. 90, beginning with another one in each row of theta_h; studies of
  // very many fits take 4 and a phi_stride of 12.
  int theta_d_stride = 1;
  int threads = 1;  // >= 1. The result is the same to the last bit for any number

  // Throws ConfigError naming the option.
  void Check() const;
};

// f: reference, g: other, ti: theta_i, to: theta_o; means are over cells and channels, and over the
// cells alone for each channel. In the logarithms f and g < 0 count as 0. NaN where nothing could
// be compared: a channel that is not finite in `other` (a fit that failed in one colour) does not
// spoil the others, and the means over channels are over those that could be compared.
struct ErrorMetrics {
  // Mean absolute logarithmic error: mean |ln(1 + f cos ti) - ln(1 + g cos ti)|, the headline.
  // Uniform in angle: a cell counts as much as its theta_h is wide.
  double male = 0;
  Rgb male_per_channel = Rgb::Zero();

  // The others count every cell alike, as their authors do, which stresses the highlight.

  // Root mean square of ln((f c + 1e-3) / (g c + 1e-3)), c = cos ti cos to: the log-relative
  // mapping of Nielsen et al. (ICCV 2015). Their division by the median material is the same in f
  // and g and cancels.
  double log_relative_rms = 0;
  Rgb log_relative_rms_per_channel = Rgb::Zero();
  double mse = 0;  // mean (f - g)^2, 1/sr^2
  double rms = 0;  // its root, 1/sr
  Rgb mse_per_channel = Rgb::Zero();
  // Root mean square of cbrt(f cos ti) - cbrt(g cos ti) (Fores et al., "Toward a perceptually based
  // metric for BRDF modeling", CIC 2012).
  double cube_root_rms = 0;
  Rgb cube_root_rms_per_channel = Rgb::Zero();
  // Mean (ln(1 + f cos ti) - ln(1 + g cos ti))^2 (Low et al., "BRDF Models for Accurate and
  // Efficient Rendering of Glossy Surfaces", ACM TOG 2012).
  double log_mse = 0;
  Rgb log_mse_per_channel = Rgb::Zero();

  // As mse, over all cells of the table, whatever max_theta: what Edahiro et al. report.
  double table_mse = 0;
  Rgb table_mse_per_channel = Rgb::Zero();

  int compared = 0;  // cells that count
  int missing = 0;  // cells where the reference has a value and `other` none: left out of all means
};

// Evaluates both at cell centres; at most 1.1 million times, so about 0.1 s plus what Eval takes.
ErrorMetrics Compare(const Brdf& reference, const Brdf& other, const MetricOptions& options = {});

// Where the headline error sits: mean |ln(1 + f cos ti) - ln(1 + g cos ti)| of one channel over the
// phi_d of each cell (theta_h, theta_d), kThetaH x kThetaD numbers, theta_h by theta_h; NaN where
// nothing can be compared.
std::vector<double> ErrorMap(const Brdf& reference, const Brdf& other, int channel,
                             const MetricOptions& options = {});

}  // namespace gonio
