// SPDX-License-Identifier: Apache-2.0
// GONIO_CHECK: aborts, in every build, when our own code has broken a promise.

#pragma once

#include <string_view>

namespace gonio {

// Prints "file:line: check failed: expression (detail)" to standard error and aborts.
[[noreturn]] void CheckFailed(const char* file, int line, const char* expression,
                              std::string_view detail);

}  // namespace gonio

// For our own bugs only. What a user or the world can cause is a ConfigError or a Result.
#define GONIO_CHECK(expression, detail)                                \
  do {                                                                 \
    if (!(expression)) [[unlikely]]                                    \
      ::gonio::CheckFailed(__FILE__, __LINE__, #expression, (detail)); \
  } while (false)
