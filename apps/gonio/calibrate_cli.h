// SPDX-License-Identifier: Apache-2.0
// The command line of `gonio calibrate`.

#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace gonio {

// Adds its subcommands and options to `app`; what is returned runs what was chosen.
std::function<int()> SetUpCalibrate(CLI::App& app);

}  // namespace gonio
