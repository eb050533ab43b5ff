// SPDX-License-Identifier: Apache-2.0
// The materials something is learned from.

#pragma once

#include <string>

#include "brdf/brdf.h"

namespace gonio {

// `name` is what the learned thing lists, so that nothing is scored on what it was taught with.
struct TrainingMaterial {
  std::string name;
  const Brdf* brdf = nullptr;  // not null; outlives the learning, not what was learned
};

}  // namespace gonio
