// SPDX-License-Identifier: Apache-2.0
// Files that are either whole or not there.

#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>

namespace gonio {

// The whole of a text file. Throws ConfigError "PATH: cannot read: REASON".
std::string ReadTextFile(const std::filesystem::path& path);

// Lets `write` fill PATH.part, flushes it to disk and renames it over PATH: readers see the old
// file or the whole new one, and nothing is left behind on failure. Throws std::runtime_error
// "PATH: cannot write: REASON" (a full disk, a missing folder); what `write` throws passes through.
void WriteFileAtomically(const std::filesystem::path& path,
                         const std::function<void(std::ostream&)>& write);

}  // namespace gonio
