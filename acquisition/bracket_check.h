// SPDX-License-Identifier: Apache-2.0
// Whether the exposures of a pose are as long as they are taken to be.
//
// Two frames of different exposures that both show the same unsaturated sites tell the ratio of
// their true exposures without any assumption: that of their signals per unit of light. Divided by
// the ratio that the reduction reckons with it is 1, but for noise.

#pragma once

#include <optional>
#include <string>

#include "acquisition/calibration/calibrations.h"
#include "acquisition/measure.h"

namespace gonio {

struct BracketMismatch {
  int channel = 0;
  double shorter = 0;   // s, as told
  double longer = 0;    // s, as told
  MeasuredValue ratio;  // of the two frames' rates, longer over shorter
  double score() const { return (ratio.value - 1) / ratio.sigma; }
};

// The pair of frames, in any channel, that agrees least by score(), over all regions together;
// empty where there is no such pair. What is known of exposures and their uncertainty
// (photon-transfer.yaml) is part of it. kRefused: as MeasureRates().
Result<std::optional<BracketMismatch>> LeastAgreement(const PoseRecord& pose, const RigConfig& rig,
                                                      const Calibrations& calibrations);

// "red of 0.01 s over 0.0001 s is 1.083 +- 0.017 times what the exposures say".
std::string TextOf(const BracketMismatch& mismatch);

}  // namespace gonio
