// SPDX-License-Identifier: Apache-2.0
// Text in CSV files.

#pragma once

#include <string>

namespace gonio {

// A field of a CSV row, in quotes.
inline std::string CsvText(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace gonio
