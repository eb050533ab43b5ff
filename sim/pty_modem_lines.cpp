// SPDX-License-Identifier: Apache-2.0
// Lets libserialport open pseudo-terminals, on which simulated controllers are served.
//
// As shipped it refuses them twice: they are not listed in /sys/class/tty, and they have no modem
// lines to ask for (TIOCMGET). An executable that links this file answers both questions itself,
// for pseudo-terminals only; all else goes where it would have gone, be that the system or another
// library that answers for it. __lxstat is what lstat was called
// when Debian 12's library was built.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstring>
#include <string>
#include <string_view>

namespace {

constexpr std::string_view kClass = "/sys/class/tty/pts/";
constexpr std::string_view kTarget = "../../devices/virtual/tty/pts";
// Majors of /dev/pts/0 and so on (Documentation/admin-guide/devices.txt of Linux).
constexpr unsigned kFirstMajor = 136;
constexpr unsigned kLastMajor = 143;

// The function of this name that would have been called without us.
template <typename Function>
Function* Next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

bool IsPty(int descriptor) {
  struct stat status = {};
  if (fstat(descriptor, &status) != 0 || !S_ISCHR(status.st_mode)) return false;
  const unsigned number = major(status.st_rdev);
  return number >= kFirstMajor && number <= kLastMajor;
}

// /dev/pts/N, if this is where the system would list it.
std::string PtyListedAs(const char* path) {
  const std::string_view listed(path);
  if (listed.substr(0, kClass.size()) != kClass) return {};
  return "/dev/pts/" + std::string(listed.substr(kClass.size()));
}

int StatusOf(const char* path, struct stat* status) {
  const std::string pty = PtyListedAs(path);
  const char* const real = pty.empty() ? path : pty.c_str();
  const int result = fstatat(AT_FDCWD, real, status, AT_SYMLINK_NOFOLLOW);
  if (result == 0 && !pty.empty()) status->st_mode = S_IFLNK | 0777;
  return result;
}

// The lines somebody set, by descriptor; those a controller would set are all on.
int Lines(int descriptor, unsigned long request, int* bits) {
  constexpr std::size_t kMost = 1024;
  static std::array<std::atomic<int>, kMost> ours;
  if (descriptor < 0 || static_cast<std::size_t>(descriptor) >= kMost) return errno = EBADF, -1;
  std::atomic<int>& lines = ours[static_cast<std::size_t>(descriptor)];
  switch (request) {
    case TIOCMGET:
      *bits = lines | TIOCM_CTS | TIOCM_DSR | TIOCM_CAR;
      break;
    case TIOCMSET:
      lines = *bits;
      break;
    case TIOCMBIS:
      lines |= *bits;
      break;
    default:
      lines &= ~*bits;
  }
  return 0;
}

}  // namespace

extern "C" {

int ioctl(int descriptor, unsigned long request, ...) noexcept {
  va_list rest;
  va_start(rest, request);
  void* const argument = va_arg(rest, void*);
  va_end(rest);
  const bool about_lines =
      request == TIOCMGET || request == TIOCMSET || request == TIOCMBIS || request == TIOCMBIC;
  if (about_lines && IsPty(descriptor)) {
    return Lines(descriptor, request, static_cast<int*>(argument));
  }
  static auto* const next = Next<int(int, unsigned long, ...)>("ioctl");
  return next(descriptor, request, argument);
}

int lstat(const char* path, struct stat* status) noexcept { return StatusOf(path, status); }

int __lxstat(int, const char* path, struct stat* status) noexcept {  // NOLINT: glibc's name
  return StatusOf(path, status);
}

ssize_t readlink(const char* path, char* target, size_t size) noexcept {
  const std::string pty = PtyListedAs(path);
  if (pty.empty() || access(pty.c_str(), F_OK) != 0) {
    static auto* const next = Next<ssize_t(const char*, char*, size_t)>("readlink");
    return next(path, target, size);
  }
  const std::size_t count = std::min(size, kTarget.size());
  std::memcpy(target, kTarget.data(), count);
  return static_cast<ssize_t>(count);
}

}  // extern "C"
