// SPDX-License-Identifier: Apache-2.0
// From the counts of one frame to electrons of signal: black level, dark and linearity taken out.
//
//   electrons = K (L(n - black) - L(dark))
//
// with n the counts, K [electrons/count] the gain, L the linearity correction and dark what
// dark_library.h says [counts]. Flat field and light come later, on the merged image.

#pragma once

#include <optional>

#include "acquisition/radiometry/dark_library.h"
#include "acquisition/radiometry/linearity.h"
#include "acquisition/radiometry/sensor.h"

namespace gonio {

// Bits of CorrectedFrame::unusable.
enum SiteFault : std::uint8_t {
  kSaturatedSite = 1,  // at full scale, above the linearity table, or next to such a site
  kBadSite = 2,        // in the mask of bad pixels
};

struct CorrectedFrame {
  SensorFormat format;
  SiteImage electrons;  // signal; negative values are kept
  SiteMask unusable;    // SiteFault bits
  double exposure = 0;  // s, true
  double monitor = 1;   // light over light at calibration
  double floor = 0;     // electrons^2: variance of a site without signal, typical of all
  SiteImage extra;      // electrons^2 that a site has on top of `floor`; empty: none
  double full = 0;      // electrons of signal at full scale
  double gain() const { return exposure * monitor; }  // s of light 1
};

struct SensorModel {
  SensorFormat format;
  double gain = 1;             // K, electrons/count
  double read_noise = 0;       // electrons
  double exposure_offset = 0;  // s, true minus told exposure
  Linearity linearity = Linearity::Identity(1e9);
  SiteMask bad;  // BadPixel bits; empty: none
};

// kRefused if the frame is of another format, or its told exposure no longer than a negative
// offset. `dark` may be null: none is subtracted. Sites next to
// a saturated one (eight neighbours, of the same colour where a pixel has three) are marked too:
// charge spills over, and their own light may be stray light of that one. Not those of a bad site.
Result<CorrectedFrame> Correct(const SensorModel& sensor, const Frame& frame, double monitor,
                               const Dark* dark);

}  // namespace gonio
