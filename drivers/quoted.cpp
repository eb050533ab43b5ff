// SPDX-License-Identifier: Apache-2.0
#include "drivers/quoted.h"

#include <fmt/format.h>

namespace gonio {

std::string Quoted(std::string_view bytes) {
  constexpr std::size_t kMost = 80;
  std::string text = "\"";
  for (const char c : bytes.substr(0, kMost)) {
    const auto byte = static_cast<unsigned char>(c);
    text += byte >= 0x20 && byte < 0x7f ? std::string(1, c) : fmt::format("\\x{:02x}", byte);
  }
  return text + (bytes.size() > kMost ? "...\"" : "\"");
}

}  // namespace gonio
