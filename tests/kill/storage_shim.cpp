// SPDX-License-Identifier: Apache-2.0
// Preloaded into gonio: counts what goes to disk, and kills the process at one of these calls.
//
//   GONIO_STORAGE_KILL=N   at the N-th call, before it is made
//   GONIO_STORAGE_TORN=1   a write is made by half first
//   GONIO_STORAGE_COUNT=F  at a normal end, the number of calls goes to this file

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>

namespace {

std::atomic<long> calls{0};

long Number(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? 0 : std::atol(text);
}

bool Due() {
  static const long kill_at = Number("GONIO_STORAGE_KILL");
  return ++calls == kill_at;
}

[[noreturn]] void Die() {
  ::kill(::getpid(), SIGKILL);
  for (;;) ::pause();
}

template <typename Function>
Function Next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

struct AtEnd {
  ~AtEnd() {
    const char* file = std::getenv("GONIO_STORAGE_COUNT");
    if (file == nullptr) return;
    if (std::FILE* out = std::fopen(file, "w")) {
      std::fprintf(out, "%ld\n", calls.load());
      std::fclose(out);
    }
  }
} at_end;

}  // namespace

extern "C" {

int fdatasync(int fd) {
  if (Due()) Die();
  static const auto next = Next<int (*)(int)>("fdatasync");
  return next(fd);
}

int fsync(int fd) {
  if (Due()) Die();
  static const auto next = Next<int (*)(int)>("fsync");
  return next(fd);
}

ssize_t pwrite64(int fd, const void* bytes, size_t size, off64_t offset) {
  static const auto next = Next<ssize_t (*)(int, const void*, size_t, off64_t)>("pwrite64");
  if (Due()) {
    if (Number("GONIO_STORAGE_TORN") != 0) (void)next(fd, bytes, size / 2, offset);
    Die();
  }
  return next(fd, bytes, size, offset);
}

}  // extern "C"
