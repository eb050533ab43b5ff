// SPDX-License-Identifier: Apache-2.0
// Ctrl-C: the first asks, the second insists.

#pragma once

#include <memory>
#include <stop_token>

namespace gonio {

// While one lives, SIGINT and SIGTERM stop a session instead of killing the process: the first
// triggers after_pose(), the second now(). The destructor gives the signals back. At most one at a
// time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  std::stop_token after_pose() const;
  std::stop_token now() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gonio
