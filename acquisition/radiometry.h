// SPDX-License-Identifier: Apache-2.0
// From counts to f_r with its standard uncertainty. docs/radiometry.md has the measurement
// equation.

#pragma once

#include <vector>

#include "acquisition/calibration/calibrations.h"
#include "acquisition/measure.h"
#include "acquisition/radiometry/uncertainty_budget.h"
#include "brdf/brdf.h"

namespace gonio {

// A sample and where its uncertainty is from. `sample.sigma` is the random part, which averages out
// over poses and which fits and planners weigh with; the systematic part is common to all samples
// of one calibration and in `budget` only. A channel that could not be measured has an infinite
// sigma and zeros in the budget.
struct ReducedSample {
  BrdfSample sample;
  UncertaintyBudget budget;
};
std::vector<BrdfSample> SamplesOf(const std::vector<ReducedSample>& reduced);

// Reduces the exposures of a pose to one sample for each of its regions, in their order.
//
// With calibrations: region_rates.h over the responsivity, theirs or, without one, the rig's.
// Without: means of counts over the pixels, which the rig's numbers turn into f_r; a channel with a
// saturated pixel is left out of that frame, frames are combined by inverse variance. A model of
// pixels that are all alike needs no more than their mean, and it is quick. Where calibrations say
// no more than the rig, both give the same within rounding (tests/calibration/).
//
// kRefused: only with calibrations, as MeasureRates().
Result<std::vector<ReducedSample>> Reduce(const PoseRecord& pose, const RigConfig& rig,
                                          const Calibrations& calibrations);
// Without calibrations.
std::vector<BrdfSample> Reduce(const PoseRecord& pose, const RigConfig& rig);

// Puts what the calibrations say in place of the rig's own numbers, for whatever predicts:
// exposures, and the noise that planners expect.
void Believe(const Calibrations& calibrations, RigConfig* rig);

// The sigma [1/sr] it would give for one frame without saturation, if f_r were this; of a light
// with colours for one frame in each. `exposures`: of each channel [s].
Rgb ExpectedSigma(const DirectionPair& pair, const Rgb& f_r, const Rgb& exposures,
                  const RigConfig& rig);

}  // namespace gonio
