// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/notify.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/utc.h"

extern char** environ;  // NOLINT: POSIX has it so

namespace gonio {
namespace {

constexpr std::chrono::seconds kLastWait{10};
constexpr std::chrono::milliseconds kPoll{20};

// A file without a name that holds `text`, to be read from its begin; -1: there is none to be had.
// No pipe: nobody has to be there to write.
int FileOf(const std::string& text) {
  const int file = ::memfd_create("notice", MFD_CLOEXEC);
  if (file < 0) return -1;
  if (::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
      ::lseek(file, 0, SEEK_SET) == 0) {
    return file;
  }
  ::close(file);
  return -1;
}

// In a process group of its own, so that Ctrl-C at the terminal is not for it. 0 or an errno.
int Spawn(const std::string& command, int input, pid_t* process) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::string shell = "sh";
  std::string option = "-c";
  std::string text = command;
  char* const arguments[] = {shell.data(), option.data(), text.data(), nullptr};
  const int error = ::posix_spawn(process, "/bin/sh", &files, &attributes, arguments, ::environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return error;
}

}  // namespace

Notifier::~Notifier() {
  const auto end = std::chrono::steady_clock::now() + kLastWait;
  for (Reap(); !running_.empty() && std::chrono::steady_clock::now() < end; Reap()) {
    std::this_thread::sleep_for(kPoll);
  }
}

void Notifier::Tell(const SessionNotice& notice) {
  if (command_.empty()) return;
  Reap();
  const nlohmann::json text = {{"kind", notice.kind},
                               {"message", notice.message},
                               {"session", std::filesystem::absolute(session_).string()},
                               {"utc", UtcText(std::time(nullptr))}};
  const int input = FileOf(text.dump() + '\n');
  if (input < 0) return Complain(std::strerror(errno));
  pid_t process = 0;
  const int error = Spawn(command_, input, &process);
  ::close(input);
  if (error != 0) return Complain(std::strerror(error));
  running_.push_back(process);
}

void Notifier::Reap() {
  std::erase_if(running_, [&](pid_t process) {
    int status = 0;
    const pid_t ended = ::waitpid(process, &status, WNOHANG);
    if (ended == 0) return false;
    if (ended == process && status != 0) {
      Complain(WIFEXITED(status) ? fmt::format("it ended with {}", WEXITSTATUS(status))
                                 : fmt::format("signal {} ended it", WTERMSIG(status)));
    }
    return true;
  });
}

void Notifier::Complain(const std::string& what) {
  if (complained_) return;
  complained_ = true;
  fmt::print(stderr, "gonio: warning: --notify {}: {}\n", command_, what);
}

}  // namespace gonio
