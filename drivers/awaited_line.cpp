// SPDX-License-Identifier: Apache-2.0
#include "drivers/awaited_line.h"

#include <fmt/format.h>

#include "drivers/deadline.h"
#include "drivers/wire_text.h"

namespace gonio {

Result<std::string> AwaitedLine(LineReader& lines, Seconds limit,
                                const std::function<bool(std::string_view)>& is_awaited) {
  const Deadline deadline(limit);
  std::string other;
  while (true) {
    Result<std::string> line = lines.Next(deadline.Left());
    if (line && is_awaited(*line)) return line;
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
