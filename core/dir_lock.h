// SPDX-License-Identifier: Apache-2.0
// One process at a time in a directory.

#pragma once

#include <filesystem>

namespace gonio {

// Holds flock(2) on the directory itself: no file is left behind, and the kernel lets go when the
// process ends, however it does.
class DirLock {
 public:
  // Throws ConfigError "DIR: another program is writing to it" or "DIR: cannot lock: REASON".
  explicit DirLock(const std::filesystem::path& dir);
  ~DirLock();
  DirLock(DirLock&& other) noexcept;
  DirLock& operator=(DirLock&&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace gonio
