// SPDX-License-Identifier: Apache-2.0
// `gonio run --notify COMMAND`: tells whoever is not there.

#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "acquisition/session.h"

namespace gonio {

// Runs a command of the user's shell for each notice, with the notice as JSON on its standard
// input: `kind`, `message`, `session`, `utc`. A session does not wait for it, nor does it fail if
// the command does; that is said on standard error, once. One thread.
class Notifier {
 public:
  // Empty: nothing is run.
  Notifier(std::string command, std::filesystem::path session)
      : command_(std::move(command)), session_(std::move(session)) {}
  // Waits up to ten seconds for what still runs, and leaves it alone then.
  ~Notifier();
  Notifier(const Notifier&) = delete;
  Notifier& operator=(const Notifier&) = delete;

  void Tell(const SessionNotice& notice);

 private:
  void Reap();
  void Complain(const std::string& what);

  const std::string command_;
  const std::filesystem::path session_;
  std::vector<pid_t> running_;
  bool complained_ = false;
};

}  // namespace gonio
