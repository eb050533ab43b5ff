// SPDX-License-Identifier: Apache-2.0
// Text that devices send.

#pragma once

#include <string>
#include <string_view>

#include "core/error.h"

namespace gonio {

// What a device sent, in quotes, as a user can read it in a message whatever bytes it is made of:
// those that are no plain text as \x1b. Cut off after `most` bytes.
std::string Quoted(std::string_view bytes, std::size_t most = 80);

// The finite number that is all of `text`. kProtocol: it is none; the message names `what`.
Result<double> NumberIn(std::string_view text, std::string_view what);

}  // namespace gonio
