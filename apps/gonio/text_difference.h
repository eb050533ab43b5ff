// SPDX-License-Identifier: Apache-2.0
// What changed in a file, line by line.

#pragma once

#include <string>

namespace gonio {

// "  - 12: old line\n  + 12: new line\n" for every line that is only in one of them, by a longest
// common subsequence, with the numbers it has there; empty: they are the same.
std::string TextDifference(const std::string& before, const std::string& now);

}  // namespace gonio
