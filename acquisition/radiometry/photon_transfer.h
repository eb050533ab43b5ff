// SPDX-License-Identifier: Apache-2.0
// Gain, read noise and full well of a sensor, from pairs of equal frames at a series of exposures.
//
// Photons arrive at random: N electrons have the variance N. So counts above black of mean m have
//
//   variance = r^2 / K^2 + 1/12 + m / K        [counts^2]
//
// with K [electrons/count] the gain, r [electrons] the read noise and 1/12 the rounding to whole
// counts. A line through variance against mean gives 1/K as its slope and r from its intercept
// (Janesick, "Photon Transfer", 2007; EMVA 1288 release 4.0, section 6). Dark current changes
// nothing: its electrons are in the mean as well as in the variance.
//
// The variance is that of the difference of two frames, halved: what a site always has more than
// its neighbour (fixed pattern) cancels. The frames are first scaled to the same mean, since a
// light that flickers by 1 % leaves 1 % of the pattern in the difference.

#pragma once

#include <array>
#include <vector>

#include "acquisition/radiometry/measured_value.h"
#include "acquisition/radiometry/sensor.h"
#include "core/error.h"

namespace gonio {

// Two frames of the same exposure and light. Evenly lit is best but not needed: the line holds for
// every site, so for their average.
struct FlatPair {
  Frame first;
  Frame second;
  double monitor_first = 1;  // the light, over the light at calibration
  double monitor_second = 1;
};

// What one pair says about one channel.
struct TransferPoint {
  int channel = 0;
  double exposure = 0;        // s
  double monitor = 1;         // mean of the two
  double mean = 0;            // counts above black, of both frames
  double mean_sigma = 0;      // from the noise of the sites; the light's own noise is not in it
  double variance = 0;        // counts^2, of one site from frame to frame
  double variance_sigma = 0;  // from the scatter of the differences
  double clipped = 0;         // fraction of the sites at full scale in either frame
  bool used = false;          // in the line
};

struct TransferOptions {
  // Points above this fraction of full scale are not used for the line; EMVA 1288 says 0.7.
  double max_fraction = 0.7;
  SiteMask bad;  // sites with a value other than 0 are left out; empty: none
};

struct PhotonTransfer {
  MeasuredValue gain;        // K, electrons/count
  MeasuredValue read_noise;  // r, electrons
  // Without light the noise spreads over less than half a count (variance < 0.24 counts^2, EMVA
  // 1288 section 6.2): rounding hides it, and read_noise is its upper limit, 0.4 counts.
  bool read_noise_hidden = false;
  // Electrons a site holds at most: the mean where the variance has collapsed, times K. If no pair
  // is that bright, the brightest mean and full_well_reached = false: it holds at least so many.
  // sigma has the uncertainty of K and how much the sites differ.
  MeasuredValue full_well;
  bool full_well_reached = false;
  bool full_well_is_full_scale = false;  // the converter ends before the sites are full
  double chi_squared = 0;                // of the line; expected: degrees_of_freedom
  int degrees_of_freedom = 0;
  std::vector<TransferPoint> points;  // all, in the order of the pairs, channels inside
};

// What each pair says. The pairs must be of `format` (kRefused, with the difference, if not) and
// have 100 good sites in every channel.
Result<std::vector<TransferPoint>> TransferPoints(const SensorFormat& format,
                                                  const std::vector<FlatPair>& pairs,
                                                  const TransferOptions& options);

// kRefused also if fewer than three points, or none of two different means, are below
// max_fraction; if the slope is not positive by five sigma.
Result<PhotonTransfer> MeasurePhotonTransfer(const SensorFormat& format,
                                             const std::vector<FlatPair>& pairs,
                                             const TransferOptions& options = {});

// True exposure over nominal exposure, for each exposure of a series, as the frames themselves say:
// their mean per unit of light, over that of the reference exposure. One channel; means must be
// linear, or corrected (linearity.h), and free of dark current.
struct ExposureRatio {
  double exposure = 0;  // s, nominal
  MeasuredValue ratio;  // 1: as told
};
// `light_noise`: relative, of one frame: the monitor's and the multiplicative noise, which has to
// average out. Points of one exposure are joined; `reference` [s] must be among them (kRefused) and
// its own noise is part of every other's sigma, so that they share it.
Result<std::vector<ExposureRatio>> ExposureRatios(const std::vector<TransferPoint>& points,
                                                  int channel, double reference,
                                                  double light_noise);

}  // namespace gonio
