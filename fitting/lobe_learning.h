// SPDX-License-Identifier: Apache-2.0
// A Gaussian over the lobes' parameters from materials.

#pragma once

#include <span>

#include "fitting/prior.h"
#include "fitting/training.h"

namespace gonio {

struct LobeLearningOptions {
  int theta_h = 30;  // rows of the raster each material is read at, dense near the mirror direction
  int theta_d = 15;
  int passes = 2;   // > 0: of fitting all materials with what the last pass learned
  int threads = 1;  // >= 1
};

// Replaces mean and covariance of `prior`, the generic one, by what DSBRDF fits of the materials
// have in common: a hierarchical Gaussian (Gelman et al., "Bayesian Data Analysis", chapter 5),
// fitted by expectation maximisation,
//
//   covariance = (sum of (p - mean)(p - mean)' + P  +  n generic covariance) / (materials + n)
//
// p, P: parameters of a material and their posterior covariance, lobes put in the order that is
// nearest to the mean. n, how many materials the generic prior is worth, is the one of a few that
// foretells materials left out best. Deterministic. About 0.2 s a material.
void LearnLobes(std::span<const TrainingMaterial> materials, const LobeLearningOptions& options,
                Prior* prior);

}  // namespace gonio
