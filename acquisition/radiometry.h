// SPDX-License-Identifier: Apache-2.0
// From counts to f_r with its standard uncertainty.

#pragma once

#include <vector>

#include "acquisition/measure.h"
#include "brdf/brdf.h"

namespace gonio {

// Reduces the exposures of a pose to one sample for each of its regions, in their order: dark and
// black level subtracted, divided by responsivity, light, exposure and cos(theta_i), combined over
// the unsaturated frames by inverse variance. sigma covers shot, read, quantisation, multiplicative
// and monitor noise; it is infinite for a channel saturated in every frame. docs/radiometry.md has
// the measurement equation.
std::vector<BrdfSample> Reduce(const PoseRecord& pose, const RigConfig& rig);

// The sigma [1/sr] it would give for one frame without saturation, if f_r were this.
Rgb ExpectedSigma(const DirectionPair& pair, const Rgb& f_r, Seconds exposure,
                  const RigConfig& rig);

}  // namespace gonio
