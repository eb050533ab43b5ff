// SPDX-License-Identifier: Apache-2.0
// How far a reflectance is from measured samples: where nobody knows more of a material than these.

#pragma once

#include <span>

#include "brdf/brdf.h"
#include "core/units.h"

namespace gonio {

// As brdf/metrics.h has them, but over readings (samples x channels), each counting alike: they say
// nothing of where nobody measured. f: the reading, g: the reflectance. In the logarithms f and g <
// 0 count as 0. NaN if nothing could be compared.
struct SampleMetrics {
  double male = 0;              // mean |ln(1 + f cos ti) - ln(1 + g cos ti)|
  double log_relative_rms = 0;  // of ln((f c + 1e-3) / (g c + 1e-3)), c = cos ti cos to
  double rms = 0;               // of f - g, 1/sr
  double z_rms = 0;             // of (f - g) / sigma: 1 if only noise sets them apart
  int readings = 0;             // that count
  int left_out = 0;  // unusable ones, those beyond max_theta, and where `other` knows nothing
};

// Readings count if theta_i and theta_o are both below max_theta [rad].
SampleMetrics CompareSamples(std::span<const BrdfSample> samples, const Brdf& other,
                             double max_theta = RadFromDeg(80));

}  // namespace gonio
