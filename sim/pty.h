// SPDX-License-Identifier: Apache-2.0
// A pseudo-terminal: a serial cable whose other end is in a program.

#pragma once

#include <string>
#include <string_view>

#include "core/clock.h"

namespace gonio {

// The controller's end. Raw; unlike a wire it has no baud rate, and bytes arrive at once.
class Pty {
 public:
  Pty();  // throws ConfigError if the system has none left
  ~Pty();
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;

  // Where a program opens the other end: "/dev/pts/3".
  const std::string& path() const { return path_; }
  void Send(std::string_view bytes);
  // What the program has sent; empty if nothing came within `limit`.
  std::string Receive(Seconds limit);
  // Pulls out the cable.
  void HangUp();

 private:
  int controller_ = -1;
  int kept_open_ = -1;  // the other end, too: while nobody has it open, waiting would not wait
  std::string path_;
};

}  // namespace gonio
