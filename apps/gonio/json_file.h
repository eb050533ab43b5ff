// SPDX-License-Identifier: Apache-2.0
// JSON for machines that read what commands print for people.

#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace gonio {

// Whole or not at all; "-" is standard output. Throws std::runtime_error.
void WriteJson(const std::filesystem::path& path, const nlohmann::json& json);

}  // namespace gonio
