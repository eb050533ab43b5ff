// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/commands.h"
#include "core/error.h"

namespace gonio {

int PlotCommand(const PlotOptions&) { throw ConfigError("not built yet"); }

}  // namespace gonio
