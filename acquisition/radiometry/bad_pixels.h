// SPDX-License-Identifier: Apache-2.0
// Sites that do not measure: hot, noisy, dead.
//
// Each property is compared with what the sites of its channel have in common: their median and
// the spread 1.4826 MAD, which bad sites themselves hardly move. Of normally distributed sites six
// in a thousand million are outside six spreads. Dark current and noise have longer tails, so a
// healthy camera also has a few hot ones; a thousandth of the sites is common, and they are simply
// left out.

#pragma once

#include <cstddef>

#include "acquisition/radiometry/dark_library.h"
#include "acquisition/radiometry/sensor.h"

namespace gonio {

// Bits of a mask.
enum BadPixel : std::uint8_t {
  kHotPixel = 1,    // dark rate far above the others
  kNoisyPixel = 2,  // scatters far more than the others from frame to frame, in the dark
  kDeadPixel = 4,   // response far from the others', or none
};

struct BadPixelLimits {
  double hot = 6;    // spreads above the median dark rate
  double noisy = 6;  // spreads above the median noise
  // Response outside 1 +- dead is no pattern any more: such a site is dead, or under dust. Not in
  // spreads: vignetting spreads the response without anything being wrong.
  double dead = 0.5;
};

struct BadPixels {
  SiteMask mask;  // BadPixel bits
  std::size_t hot = 0;
  std::size_t noisy = 0;
  std::size_t dead = 0;
  // Fraction of all sites that are bad in any way.
  double fraction() const;
};

// `response`: relative response of each site to even light (flat_field.h), mean about 1; empty: not
// looked at. Both must have the sites of `format`.
BadPixels FindBadPixels(const SensorFormat& format, const DarkFit& dark, const SiteImage& response,
                        const BadPixelLimits& limits = {});

}  // namespace gonio
