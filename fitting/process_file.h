// SPDX-License-Identifier: Apache-2.0
// The process in a prior file (docs/data-format.md).

#pragma once

#include <memory>
#include <ostream>

#include "core/config.h"
#include "fitting/process_prior.h"

namespace gonio {

// "process:" and the lines below it. Components are rounded to five digits: what they describe is
// known to fewer.
void WriteProcess(std::ostream& out, const ProcessPrior& process);
// The mapping those lines make. Throws ConfigError: sizes, spreads < 0, numbers that are not
// finite.
std::shared_ptr<const ProcessPrior> ReadProcess(const ConfigNode& node);

}  // namespace gonio
