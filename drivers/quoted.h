// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace gonio {

// What a device sent, in quotes, as a user can read it in a message whatever bytes it is made of:
// those that are no plain text as \x1b. Cut off after 80 bytes.
std::string Quoted(std::string_view bytes);

}  // namespace gonio
