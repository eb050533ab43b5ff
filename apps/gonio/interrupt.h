// SPDX-License-Identifier: Apache-2.0
// Ctrl-C and its kin: asking, insisting, and an end without asking.

#pragma once

#include <memory>
#include <stop_token>

namespace gonio {

// While one lives, signals steer a session instead of killing the process.
//
//              at a terminal                                 without one
//   1st SIGINT   pause after this pose; Enter goes on            stop after this pose
//   2nd          stop the arms at once                           stop the arms at once
//   3rd          end the process, whatever the devices do        the same
//   while paused stop: the session ends cleanly
//
// SIGTERM and SIGHUP (the terminal is gone) are those without a terminal; SIGUSR1 goes on with what
// is paused, as Enter does. A SIGHUP that was ignored when it was made, as nohup does, stays
// ignored. The destructor gives the signals back. At most one at a time.
class Interrupt {
 public:
  // `keyboard`: a descriptor on which a line is Enter; -1: there is nobody to press it.
  explicit Interrupt(int keyboard = -1);
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  std::stop_token after_pose() const;
  std::stop_token now() const;

  // Whether a pause was asked for. Any thread, as the next.
  bool pausing() const;
  // Blocks until Enter or SIGUSR1, after which there is no pause any more, or one of the tokens is
  // triggered: by a signal, or because the keyboard is gone. Also where no pause was asked for, if
  // the session wants a person.
  void WaitWhilePaused();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gonio
