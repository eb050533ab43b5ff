// SPDX-License-Identifier: Apache-2.0
// From samples to a reflectance, by any of the ways a frontier study compares.

#pragma once

#include <memory>
#include <span>

#include "apps/gonio/frontier_config.h"
#include "apps/gonio/frontier_folds.h"

namespace gonio {

// `plan` brings prior and fit options; `learned` is null for a contestant that is not taught.
// Throws ConfigError if the samples do not suffice.
std::unique_ptr<Brdf> Reconstruct(Reconstruction how, std::span<const BrdfSample> samples,
                                  const Plan& plan, const Knowledge* learned);

}  // namespace gonio
