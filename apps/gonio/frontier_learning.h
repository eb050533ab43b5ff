// SPDX-License-Identifier: Apache-2.0
// What a frontier study learns from its training materials.

#pragma once

#include <memory>
#include <span>
#include <string>

#include "apps/gonio/frontier_folds.h"

namespace gonio {

// Opens the materials and learns a prior that lists them. Throws ConfigError.
Prior LearnFrom(std::span<const FrontierMaterial> materials, const std::string& name);

// The same for principal components. One fold at a time, since all materials are in memory.
std::shared_ptr<const PcaBasis> LearnPca(std::span<const FrontierMaterial> materials);

}  // namespace gonio
