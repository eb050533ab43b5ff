// SPDX-License-Identifier: Apache-2.0
#include "core/dir_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "core/error.h"

namespace gonio {

DirLock::DirLock(const std::filesystem::path& dir)
    : descriptor_(::open(dir.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
  const int error = errno;
  if (descriptor_ >= 0) ::close(descriptor_);
  if (error == EWOULDBLOCK) {
    throw ConfigError(dir.string() + ": another program is writing to it");
  }
  throw ConfigError(
      fmt::format("{}: cannot lock: {}", dir.string(), std::generic_category().message(error)));
}

DirLock::~DirLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

DirLock::DirLock(DirLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

}  // namespace gonio
