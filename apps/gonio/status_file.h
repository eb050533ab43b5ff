// SPDX-License-Identifier: Apache-2.0
// DIR/status.json: how a session is doing, for other programs.

#pragma once

#include <chrono>
#include <filesystem>
#include <optional>

#include "acquisition/session.h"
#include "apps/gonio/time_left.h"

namespace gonio {

// Rewritten whole, by a rename, so that a reader never sees half of it; at most once a second, and
// at every change of state. Nothing reads it back: a status that cannot be written is no reason to
// end a measurement. One thread.
class StatusFile {
 public:
  explicit StatusFile(std::filesystem::path dir) : path_(std::move(dir) / "status.json") {}

  void Enter(SessionState state);
  void Show(const Progress& progress);
  void End(const SessionSummary& summary);

 private:
  void Write() const;

  const std::filesystem::path path_;
  SessionState state_ = SessionState::kUnhomed;
  std::optional<Progress> progress_;
  const SessionSummary* summary_ = nullptr;
  TimeLeft left_;
  std::chrono::steady_clock::time_point written_{};
};

}  // namespace gonio
