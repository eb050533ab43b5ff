// SPDX-License-Identifier: Apache-2.0
#include "core/file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "core/error.h"

namespace gonio {
namespace {

std::string Reason(int error) { return std::generic_category().message(error); }

// Forces what was written to `path` (a file or a folder) onto the disk; returns errno or 0.
int SyncPath(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return errno;
  const int error = ::fsync(fd) == 0 ? 0 : errno;
  ::close(fd);
  return error;
}

}  // namespace

std::string ReadTextFile(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) {
    throw ConfigError(path.string() + ": cannot read: is a directory");
  }
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (!in || (in.peek() != EOF && !(text << in.rdbuf()))) {
    throw ConfigError(path.string() + ": cannot read: " + Reason(errno != 0 ? errno : EIO));
  }
  return text.str();
}

void WriteFileAtomically(const std::filesystem::path& path,
                         const std::function<void(std::ostream&)>& write) {
  std::filesystem::path part = path;
  part += ".part";
  struct RemoveOnFailure {
    std::filesystem::path file;
    ~RemoveOnFailure() {
      std::error_code ignored;
      if (!file.empty()) std::filesystem::remove(file, ignored);
    }
  } guard{part};
  const auto fail = [&](int error) {
    throw std::runtime_error(path.string() + ": cannot write: " + Reason(error != 0 ? error : EIO));
  };

  errno = 0;
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  if (!out) fail(errno);
  write(out);
  out.flush();
  const int write_error = errno;
  out.close();
  if (!out) fail(write_error);
  if (const int error = SyncPath(part)) fail(error);
  std::error_code renamed;
  std::filesystem::rename(part, path, renamed);
  if (renamed) fail(renamed.value());
  guard.file.clear();
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (const int error = SyncPath(folder)) fail(error);
}

}  // namespace gonio
