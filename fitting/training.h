// SPDX-License-Identifier: Apache-2.0
// Materials to learn from.

#pragma once

#include <string>

#include "brdf/brdf.h"

namespace gonio {

struct TrainingMaterial {
  std::string name;  // as it will be listed by what was learned from it
  const Brdf* brdf = nullptr;
};

}  // namespace gonio
