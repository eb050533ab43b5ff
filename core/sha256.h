// SPDX-License-Identifier: Apache-2.0
// SHA-256 (FIPS 180-4), to name configurations and material files in the event log.

#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace gonio {

// 64 lower-case hexadecimal digits, as `sha256sum` prints them.
std::string Sha256(std::string_view bytes);

// Of a whole file. Throws ConfigError if it cannot be read.
std::string Sha256OfFile(const std::filesystem::path& path);

}  // namespace gonio
