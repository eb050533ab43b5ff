// SPDX-License-Identifier: Apache-2.0
// The command line.

#pragma once

namespace gonio {

// Parses, runs the command and returns its exit code; help and version are printed here. Throws
// ConfigError on a command line that makes no sense, and whatever the command throws.
int RunCommandLine(int argc, char** argv);

}  // namespace gonio
