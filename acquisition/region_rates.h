// SPDX-License-Identifier: Apache-2.0
// What the frames of a pose say of the light that came from each of its regions, with calibrations.
//
// Per frame counts become electrons (radiometry/frame_correction.h), frames are merged, the flat
// field is divided out, and the mean over a region is taken, less stray light:
//
//   rate = R f_r      electrons/s, per unit of ImageRegion::light, at light 1
//
// Frames lit in a colour of the light are merged apart from those in another, with the flat field
// of that colour, and say the rate of its channel.
//
// R is the responsivity, which a standard tells (calibration/) and with which f_r is told
// (radiometry.h). What no file says is as RigConfig::radiometry says: gain, read noise, dark
// current, noise of the light.

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "acquisition/calibration/calibrations.h"
#include "acquisition/measure.h"
#include "acquisition/radiometry/uncertainty_budget.h"

namespace gonio {

// One channel of one region.
struct RegionRate {
  bool measured = false;  // false: saturated in every frame, or no good pixel
  double rate = 0;        // as above
  // Standard uncertainties in the unit of `rate`, by UncertaintyTerm; none of the responsivity.
  std::array<double, kUncertaintyTerms> terms{};

  double random() const;
  double systematic() const;
};
using RegionRates = std::array<RegionRate, kChannels>;

// For each region of `pose`, in their order. kRefused, with the reason: frames of another format,
// or one that the darks do not reach (exposure, temperature).
Result<std::vector<RegionRates>> MeasureRates(const PoseRecord& pose, const RigConfig& rig,
                                              const Calibrations& calibrations);

// The sites of one channel of a region; of a mono camera those of all channels.
std::vector<std::uint32_t> SitesOf(const SensorFormat& format, const ImageRegion& region,
                                   int channel);

// The sensor as the files say, where they do not as the rig does.
SensorModel SensorModelOf(const RigConfig& rig, const Calibrations& calibrations);

// What a frame has without light: of the darks, if there are any, otherwise the rig's dark current
// of all sites alike. kRefused: as above.
Result<Dark> DarkOf(const RigConfig& rig, const Calibrations& calibrations, const Frame& frame);

}  // namespace gonio
