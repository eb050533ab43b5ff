// SPDX-License-Identifier: Apache-2.0
// What `gonio simulate` measures: materials from files, or drawn from a prior.

#pragma once

#include <string>
#include <vector>

#include "apps/gonio/simulate_session.h"

namespace gonio {

// Opens them and warns on standard error where a plan's prior was learned from one. Throws
// ConfigError.
std::vector<NamedMaterial> OpenMaterials(const std::vector<std::string>& files,
                                         const std::vector<NamedPlan>& plans);

// The first learned prior of the plans. Throws ConfigError if there is none.
const Prior& SourceOfDraws(const std::vector<NamedPlan>& plans);

// `count` materials as SourceOfDraws() expects them, stationary part included: "draw 1" and so on.
// Number i is the same whatever the count. Throws ConfigError if there is no such prior.
std::vector<NamedMaterial> DrawMaterials(int count, std::uint64_t seed,
                                         const std::vector<NamedPlan>& plans);

}  // namespace gonio
