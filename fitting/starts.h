// SPDX-License-Identifier: Apache-2.0
// Where a fit starts: several explanations of the data, none of them left to luck.

#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "brdf/brdf.h"
#include "fitting/prior.h"

namespace gonio {

// Parameter vectors to start from: the prior's mean, and copies of it whose diffuse lobe has the
// level the readings away from the mirror direction show and whose narrowest lobe has the height of
// the readings near it, with each of a ladder of widths. Always in the same order.
std::vector<Eigen::VectorXd> FitStarts(std::span<const BrdfSample> samples, const Prior& prior);

}  // namespace gonio
