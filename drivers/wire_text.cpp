// SPDX-License-Identifier: Apache-2.0
#include "drivers/wire_text.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <iterator>

namespace gonio {

std::string Quoted(std::string_view bytes, std::size_t most) {
  std::string text = "\"";
  for (const char c : bytes.substr(0, most)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte < 0x7f) {
      text += c;
    } else {
      fmt::format_to(std::back_inserter(text), "\\x{:02x}", byte);
    }
  }
  return text + (bytes.size() > most ? "...\"" : "\"");
}

Result<double> NumberIn(std::string_view text, std::string_view what) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return Error{ErrorCode::kProtocol, fmt::format("{} is {}, not a number", what, Quoted(text))};
  }
  return value;
}

}  // namespace gonio
