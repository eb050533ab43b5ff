// SPDX-License-Identifier: Apache-2.0
// Several exposures of one pose into one image of rates, each exposure weighted by what it knows.
//
// A site that receives the rate x [electrons/s at light 1] gives, in frame k with g_k = t_k M_k
// [s],
//
//   e_k = x g_k (1 + m_k) + noise,     E e_k = x g_k,
//   var_k = x g_k + f_k  per site,     and  (rho x g_k)^2  common to all sites of the frame
//
// with f_k the variance without signal (read noise, rounding, dark) and rho the relative noise that
// all sites share: multiplicative and monitor noise. Each frame says x_k = e_k / g_k, and the merge
// is x = sum_k w_k x_k / sum_k w_k over the frames in which the site is usable.
//
// Which weights? The mean over N sites that receive the same is again such a sum, of frame means
// with variance ((x g_k + f_k) / N + (rho x g_k)^2) / g_k^2, so the best weights for that mean are
//
//   w_k = g_k^2 / ((x g_k + f_k) / N + (rho x g_k)^2)
//
// If all N sites use these same weights, the mean of the merged sites equals the merge of the
// frame means: sum_p sum_k w_k x_k(p) / N = sum_k w_k mean_p x_k(p). So it does not matter whether
// sites or frames are averaged first, *provided* N is the number of sites that will be averaged
// and x in the weights is not the site's own noisy value. Weighting each site as if it stood alone
// (N = 1) would trust long exposures for their little shot noise, though their draw of m_k is as
// bad as that of short ones. x in the weights is the mean over a tile of sites of one channel, and
// at least zero: the expected signal, not the noisy one (docs/radiometry.md). Any x there leaves
// the merge unbiased; a wrong one costs only precision.
//
// Near full scale: whoever uses a frame where it happens to be unsaturated uses it only when noise
// took it down. So a weight is also multiplied by a factor that falls smoothly from 1 where the
// tile is expected at `taper_begin` of full scale to 0 at `taper_end`. It depends on the expected
// signal alone, and changes little within that signal's own error: a hard limit merely moves the
// selection from the full scale to the limit. If only such frames are left, the factors cancel as
// far as they are not zero. Saturated sites and their neighbours are masked one by one besides, and
// a tile whose expected signal is past `taper_end` in all frames is saturated.
//
// The weights of Debevec and Malik (SIGGRAPH 1997) are a triangle over the counts; of Robertson et
// al. (1999), the counts' variance alone: neither knows the noise of the light or the read noise.
// For those of a camera see Hasinoff et al., CVPR 2010.

#pragma once

#include <vector>

#include "acquisition/radiometry/frame_correction.h"
#include "acquisition/radiometry/sensor.h"
#include "core/error.h"

namespace gonio {

struct MergeOptions {
  double shared_noise = 0;    // rho, relative, of one frame
  double averaged_sites = 1;  // N: how many sites of a channel will be averaged
  int tile = 16;              // pixels: side of the squares that share their weights; even
  double taper_begin = 0.75;  // of full scale
  double taper_end = 0.95;
};

// The weights of such frames for a mean over `averaged_sites` sites that receive `rate`
// [electrons/s at light 1] each, tapered, the largest 1; all 0 if every frame is too bright. What
// Merge() uses in a tile where it expects that rate: for whoever wants to know what a frame's error
// is in the merge, w_k / (g_k sum w).
std::vector<double> MergeWeights(const std::vector<CorrectedFrame>& frames, double rate,
                                 const MergeOptions& options);

// Bits of MergedImage::state; 0: a rate is known and stands out of the noise.
enum MergedState : std::uint8_t {
  kAllSaturated = 1,  // no frame is short enough: rate 0, variance infinite
  kAllBad = 2,        // a bad pixel: rate 0, variance infinite
  kAllDark = 4,  // within three sigma of nothing in all frames together: rate and variance hold
};

struct MergedImage {
  SensorFormat format;
  SiteImage rate;      // electrons/s at light 1
  SiteImage variance;  // (electrons/s)^2, of the noise that sites do not share
  // Relative variance that all sites share if they use the same frames: rho^2 sum w^2 / (sum w)^2.
  SiteImage shared;
  SiteMask state;
};

// The variance of a site is the sum of the w^2 var_k with the merged rate, at least zero, for x: it
// is linear in x, so its mean over many sites is right though single ones scatter. kRefused if the
// frames are of different formats or none.
Result<MergedImage> Merge(const std::vector<CorrectedFrame>& frames,
                          const MergeOptions& options = {});

}  // namespace gonio
