// SPDX-License-Identifier: Apache-2.0
// Whether a session's file is what was written, and what of a damaged one can be kept.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gonio {

// What is wrong, one line each, the first few of a kind; empty: every page, row and frame is as it
// was written. Looks at everything: seconds per gigabyte. Throws ConfigError if the file cannot be
// opened or is no session.
std::vector<std::string> FindDamage(const std::filesystem::path& session);

struct Rescued {
  int poses = 0;                  // kept
  int lost_poses = 0;             // of those whose number is still known
  std::vector<std::string> lost;  // what, one line each
};

// Makes `to`, which must not exist, of all of a damaged session that is whole: poses with their
// events, their frames, whose SHA-256 must be right, and their samples. Poses behind a lost one are
// numbered anew. `from` is only read. Throws ConfigError if nothing can be kept: what the session
// was run with (`meta`) is damaged.
Rescued RescueSession(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace gonio
