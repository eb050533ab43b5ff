// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/error.h"

namespace gonio {

// What ask() returns: of a second try if the first was not answered in time or made no sense. For
// questions, which do no harm when asked twice; never for commands.
template <typename Ask>
auto AskedTwice(Ask ask) -> decltype(ask()) {
  auto answer = ask();
  if (answer) return answer;
  const ErrorCode code = answer.error().code;
  return code == ErrorCode::kTimeout || code == ErrorCode::kProtocol ? ask() : answer;
}

}  // namespace gonio
