// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/json_file.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/file.h"

namespace gonio {

void WriteJson(const std::filesystem::path& path, const nlohmann::json& json) {
  const std::string text = json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
  if (path == "-") {
    fmt::print("{}\n", text);
    return;
  }
  WriteFileAtomically(path, [&](std::ostream& out) { out << text << '\n'; });
}

}  // namespace gonio
