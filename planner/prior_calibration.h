// SPDX-License-Identifier: Apache-2.0
// How far a learned prior's own uncertainty can be trusted, measured.

#pragma once

#include <span>
#include <vector>

#include "fitting/learn_prior.h"

namespace gonio {

struct CalibrationOptions {
  int folds = 4;                         // >= 2
  std::vector<int> poses = {8, 16, 32};  // ascending, > 0: where a session is judged
  int directions = 400;                  // > 0: and against so many
  double share = 0.85;                   // 0 .. 1: of sessions whose error the margin shall cover
};

// LearnPrior() of all materials, with `calibration` and `error_margin` of its process measured: the
// materials are divided into folds, a process is learned from the others of each, and a session
// with its planner (planner/process_planner.h) is simulated on every material left out; noise-free,
// for what is judged is how materials differ. So nothing but training materials is looked at.
//
//   calibration   ratio of deviations of z from prediction to what the process said, at the
//                 quantiles of a few probabilities, against a Gaussian's
//   error_margin  quantile `share` of the ratio of true to expected error
//
// With fewer than kLeastToCalibrate materials quantiles would say little: what LearnPrior() says is
// returned. Throws what LearnPrior() throws. Deterministic, whatever the number of threads. About
// 1 s a material.
inline constexpr int kLeastToCalibrate = 10;
Prior LearnCalibratedPrior(std::span<const TrainingMaterial> materials,
                           const LearnOptions& learn = {}, const CalibrationOptions& options = {});

}  // namespace gonio
