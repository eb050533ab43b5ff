// SPDX-License-Identifier: Apache-2.0
// By how much exposures are longer than the camera says.
//
// Shutters and row timers are late by a constant: t_true = t + t0. Without dark and bias a frame of
// a steady light reads
//
//   y(t) = a (t + t0)         counts per light 1
//
// a line whose intercept over its slope is t0. Exposures near zero, where little else than t0 is
// left, tell it; brighter ones tell a. A scale common to all exposures cannot be told from the
// responsivity and is part of it.

#pragma once

#include <vector>

#include "acquisition/radiometry/dark_library.h"
#include "acquisition/radiometry/measured_value.h"
#include "acquisition/radiometry/photon_transfer.h"

namespace gonio {

struct ExposureOffset {
  MeasuredValue offset;  // t0, s; positive: longer than told
  double chi_squared = 0;
  int degrees_of_freedom = 0;
};

struct ExposureOffsetOptions {
  double light_noise = 0;  // relative, of one frame: monitor and multiplicative noise
  double max_counts = 0;   // brighter points are left out: where the sensor may bend
  SiteMask bad;            // as TransferOptions::bad
};

// From the points of TransferPoints(), of the frames' own exposures; `dark` is what these frames
// have without light, and its noise is in the result. Channels are joined. kRefused where no
// channel has points of two different exposures, or one does not grow with the exposure.
Result<ExposureOffset> MeasureExposureOffset(const std::vector<TransferPoint>& points,
                                             const DarkFit& dark, const SensorFormat& format,
                                             const ExposureOffsetOptions& options);

}  // namespace gonio
