// SPDX-License-Identifier: Apache-2.0
#include "sim/pty_server.h"

#include <utility>

namespace gonio {
namespace {

constexpr Seconds kPatience{0.02};  // how late the end may be noticed

}  // namespace

PtyServer::PtyServer(Device device)
    : device_(std::move(device)), path_(pty_.path()), thread_([this] { Serve(); }) {}

PtyServer::~PtyServer() { HangUp(); }

void PtyServer::HangUp() {
  ended_ = true;
  if (thread_.joinable()) thread_.join();
  pty_.HangUp();
}

void PtyServer::Serve() {
  while (!ended_) {
    const std::string bytes = pty_.Receive(kPatience);
    if (!bytes.empty()) pty_.Send(device_(bytes));
  }
}

}  // namespace gonio
