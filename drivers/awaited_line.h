// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "drivers/deadline.h"
#include "drivers/line_reader.h"
#include "drivers/wire_text.h"

namespace gonio {

// The first line for which is_awaited(line) holds; those before it are passed over. kProtocol: only
// others came in time, or what is no line at all. kTimeout: nothing did.
template <typename IsAwaited>
Result<std::string> AwaitedLine(LineReader& lines, Seconds limit, IsAwaited is_awaited) {
  const Deadline deadline(limit);
  std::string other;
  while (true) {
    Result<std::string> line = lines.Next(deadline.Left());
    if (line && is_awaited(std::string_view(*line))) return line;
    if (line) {
      other = Quoted(*line);
    } else if (other.empty() || line.error().code != ErrorCode::kTimeout) {
      return line;
    }
    if (!other.empty() && deadline.Left() <= Seconds(0)) {
      return Error{ErrorCode::kProtocol, fmt::format("{} is not what was asked for", other)};
    }
  }
}

}  // namespace gonio
