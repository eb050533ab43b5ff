// SPDX-License-Identifier: Apache-2.0
#include "sim/pty_server.h"

#include <utility>

namespace gonio {
namespace {

constexpr Seconds kPatience{0.02};  // how late the end may be noticed

}  // namespace

PtyServer::PtyServer(Device device, Unasked unasked)
    : device_(std::move(device)),
      unasked_(std::move(unasked)),
      path_(pty_.path()),
      thread_([this] { Serve(); }) {}

PtyServer::~PtyServer() { HangUp(); }

void PtyServer::HangUp() {
  ended_ = true;
  if (thread_.joinable()) thread_.join();
  pty_.HangUp();
}

void PtyServer::set_silent(bool silent) { silent_ = silent; }
void PtyServer::Garble(int answers) { garbled_ = answers; }

void PtyServer::Serve() {
  while (!ended_) {
    const std::string bytes = pty_.Receive(kPatience);
    if (bytes.empty() && !unasked_) continue;
    std::string answer = bytes.empty() ? unasked_() : device_(bytes);
    if (silent_ || answer.empty()) continue;
    if (garbled_ > 0 && answer.size() > 1) {
      --garbled_;
      answer[1] ^= 2;
    }
    pty_.Send(answer);
  }
}

}  // namespace gonio
