// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "drivers/line_reader.h"

namespace gonio {

// The first line for which is_awaited(line) holds; those before it are passed over. kProtocol: only
// others came in time, or what is no line at all. kTimeout: nothing did.
Result<std::string> AwaitedLine(LineReader& lines, Seconds limit,
                                const std::function<bool(std::string_view)>& is_awaited);

}  // namespace gonio
