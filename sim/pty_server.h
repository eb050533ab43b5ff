// SPDX-License-Identifier: Apache-2.0
// A device that listens at the end of a pseudo-terminal.

#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <string_view>
#include <thread>

#include "sim/pty.h"

namespace gonio {

// Hands what a program sends to `device`, byte runs as they come, and sends back what it answers,
// on a thread of its own until destroyed; between them what it has to say unasked.
class PtyServer {
 public:
  using Device = std::function<std::string(std::string_view bytes)>;

  // What a device says without being asked; called many times a second. Empty: nothing.
  using Unasked = std::function<std::string()>;

  explicit PtyServer(Device device, Unasked unasked = {});
  ~PtyServer();

  const std::string& path() const { return path_; }

  // Faults of the wire. Any thread.
  void HangUp();                 // pulls out the cable: the program finds itself disconnected
  void set_silent(bool silent);  // the device hears and does, but no answer arrives
  void Garble(int answers);      // a bit in the second byte of each of the next ones is wrong

 private:
  void Serve();

  Device device_;
  Unasked unasked_;
  Pty pty_;
  std::string path_;
  std::atomic<bool> ended_ = false;
  std::atomic<bool> silent_ = false;
  std::atomic<int> garbled_ = 0;
  std::thread thread_;
};

}  // namespace gonio
