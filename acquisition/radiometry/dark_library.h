// SPDX-License-Identifier: Apache-2.0
// What a sensor reads without light: per site a bias and a dark current, and the noise of both.
//
//   dark counts above Frame::black_level = bias(p) + rate(p) t + noise
//
// Bias and rate of each site are the least-squares line through the means of its frames at several
// exposures t, each mean weighted by its number of frames. Because all sites share the exposures,
// they share the coefficients of that line:
//
//   bias = sum_k a_k mean_k,   rate = sum_k b_k mean_k
//
// and the dark of exposure t has the variance
//
//   sum_k (a_k + b_k t)^2 (v + rate t_k / K) / n_k + rounding        [counts^2]
//
// with v the read noise that sites share (the mean of the quieter half, not each one's own scatter:
// of eight frames it is known to a quarter only) and rate t_k / K the shot noise of the
// dark current. The error of a site's dark is the same in all frames that are corrected with it:
// systematic for that site, independent from site to site.
//
// Dark current doubles every 5 .. 9 degrees (Janesick, "Scientific Charge-Coupled Devices", 2001,
// ch. 7), so a library is one list of temperatures, and the nearest is used within a limit; what
// the rest may change is in `temperature_sigma`.

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "acquisition/radiometry/sensor.h"
#include "core/error.h"

namespace gonio {

// Of one temperature.
struct DarkFit {
  double temperature_c = 0;  // mean of its frames
  SiteImage bias;            // counts above Frame::black_level
  SiteImage rate;            // counts/s; noise can make it negative
  SiteImage noise;           // counts rms from frame to frame, of each site by itself
  double read_variance = 0;  // v, counts^2, of one frame
  struct Level {
    double exposure = 0;  // s
    int frames = 0;
    double to_bias = 0;  // a_k
    double to_rate = 0;  // b_k, 1/s
  };
  std::vector<Level> levels;  // ascending in exposure
};

struct DarkLibrary {
  SensorFormat format;
  double gain = 1;            // K, electrons/count
  std::int64_t created = 0;   // s since 1970-01-01 UTC
  std::vector<DarkFit> fits;  // ascending in temperature
};

// Without light, of one gain; temperatures within `temperature_step` [K] of the first of a group
// are one temperature, and frames without one are all of 0 degrees. kRefused if a frame is of
// another format, or a temperature has fewer than two exposures or two frames of each.
Result<DarkLibrary> MeasureDark(const SensorFormat& format, const std::vector<Frame>& frames,
                                double gain, std::int64_t created, double temperature_step = 1);

struct DarkLimits {
  double max_age = 30 * 86400.0;          // s
  double max_temperature_difference = 2;  // K, between frame and fit
  double doubling = 6;                    // K: dark current doubles
};

// What to subtract from a frame, counts above Frame::black_level, per site.
struct Dark {
  SiteImage counts;
  SiteImage variance;  // counts^2, of `counts`: independent from site to site
  // Relative to the part of `counts` that dark current is; common to all sites.
  double temperature_sigma = 0;
  SiteImage current;  // counts: that part, for its shot noise; at least zero
};

// For frames of `format`, taken at `now` [s since 1970]. kRefused with the reason: another format,
// a library older than the limit or from the future, an exposure longer than the longest of the
// library, no fit near the temperature. Without a temperature, only a library of a single
// temperature will do.
Result<Dark> DarkFor(const DarkLibrary& library, const SensorFormat& format, double exposure,
                     std::optional<double> temperature_c, std::int64_t now,
                     const DarkLimits& limits = {});

// Variance that rounding adds to a mean of counts with noise variance v [counts^2], because their
// rounding errors are alike: exp(-4 pi^2 v) / 12 (Widrow and Kollar, "Quantization Noise", 2008).
double SharedRounding(double variance);

}  // namespace gonio
