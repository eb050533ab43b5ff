// SPDX-License-Identifier: Apache-2.0
// The mean of a region of a merged image, with its variance and how uneven it is.
//
// Site p of the region receives x_p = s l_p, where l_p is the light that falls on what it sees
// (cos(theta_i) and distance, ImageRegion::lights) and s is wanted: electrons/s per unit of light.
//
//   s = sum_p x_p / sum_p l_p,   var(s) = sum_p var(x_p) / (sum_p l_p)^2  + shared s^2
//
// over the sites used. This ratio of sums, unlike a mean of the ratios, does not give dim sites
// more weight than their signal deserves, nor does it weigh with noisy variances.
//
// Robust: a site whose x_p / l_p is further than `outlier` robust spreads (1.4826 MAD) from the
// median of its channel is dust, a glint or a cosmic ray, and left out. Not a cure for an uneven
// region: `unevenness` is what scatters beyond the noise, in parts of the mean.

#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "acquisition/radiometry/hdr_merge.h"
#include "brdf/brdf.h"

namespace gonio {

struct ChannelStatistics {
  double mean = 0;      // s, electrons/s per unit of light; negative values are kept
  double variance = 0;  // of `mean`, of noise that sites do not share
  double shared = 0;    // relative variance of the noise that they share: rho^2 of the merge
  double spread = 0;    // standard deviation of single sites' x_p / l_p
  // Relative to |mean|: what of `spread` the noise does not explain; zero if that is nothing.
  double unevenness = 0;
  double light = 0;  // mean l_p of the sites used
  int used = 0;      // sites
  int outliers = 0;  // left out as above
  int saturated = 0;
  int bad = 0;
  // Standard uncertainty of `mean`; infinite without sites.
  double sigma() const;
};

// `pixels`: row * width + column; `lights`: of each of them, > 0; empty: all 1. A Bayer pixel
// counts for its own colour, a mono pixel for all three alike. `outlier` 0: all are kept.
std::array<ChannelStatistics, kChannels> StatisticsOf(const MergedImage& image,
                                                      std::span<const std::uint32_t> pixels,
                                                      std::span<const float> lights,
                                                      double outlier = 6);

}  // namespace gonio
