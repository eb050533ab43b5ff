// SPDX-License-Identifier: Apache-2.0
// Points in time as files write them.

#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace gonio {

// Seconds since 1970 as "2024-05-03T09:12:44Z", and back; empty if it is no such date.
std::string UtcText(std::int64_t seconds);
std::optional<std::int64_t> SecondsOfUtc(const std::string& text);

}  // namespace gonio
