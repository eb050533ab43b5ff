// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/locate.h"

#include <fmt/format.h>

#include <cstdlib>
#include <system_error>

#include "core/error.h"

namespace gonio {

namespace fs = std::filesystem;

fs::path ConfigDir() {
  std::error_code ignored;
  if (const char* dir = std::getenv("GONIO_CONFIG_DIR"); dir != nullptr && *dir != '\0') {
    if (!fs::is_directory(dir)) {
      throw ConfigError(fmt::format("GONIO_CONFIG_DIR: {}: no such directory", dir));
    }
    return dir;
  }
  const fs::path binary = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path beside = binary.parent_path().parent_path() / "share/goniopilot/configs";
  for (const fs::path& dir : {beside, fs::path(GONIO_SOURCE_CONFIG_DIR)}) {
    if (fs::is_directory(dir, ignored)) return dir;
  }
  return GONIO_INSTALL_CONFIG_DIR;
}

fs::path LocateConfig(const std::string& name) {
  std::error_code ignored;
  if (fs::exists(name, ignored)) return name;
  if (fs::path(name).has_parent_path()) throw ConfigError(name + ": no such file");
  const fs::path dir = ConfigDir();
  for (const fs::path& file : {dir / name, dir / "materials" / name}) {
    if (fs::exists(file, ignored)) return file;
  }
  throw ConfigError(fmt::format("{}: no such file, neither here nor in {}", name, dir.string()));
}

}  // namespace gonio
