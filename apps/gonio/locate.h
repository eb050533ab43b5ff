// SPDX-License-Identifier: Apache-2.0
// Finds the configurations that gonio comes with.

#pragma once

#include <filesystem>
#include <string>

namespace gonio {

// The first that exists: $GONIO_CONFIG_DIR, ../share/goniopilot/configs beside the running binary,
// the source tree it was built from, the place it was to be installed to.
std::filesystem::path ConfigDir();

// `name` if there is such a file; else the file of that name in ConfigDir() or in its materials/,
// unless `name` has a folder in it. Throws ConfigError "NAME: no such file, neither here nor in
// DIR".
std::filesystem::path LocateConfig(const std::string& name);

// The material that is measured when none is named.
inline constexpr const char* kDefaultMaterial = "satin-paint.yaml";

}  // namespace gonio
