// SPDX-License-Identifier: Apache-2.0
// The raw frames of a session, as they left the detector.

#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "acquisition/frame_taker.h"

namespace gonio {

// Reads them pose by pose: all at once may not fit into memory. One thread.
class SessionFrames {
 public:
  // Read-only. Throws ConfigError as ReadSession() does.
  explicit SessionFrames(const std::filesystem::path& dir);
  ~SessionFrames();
  SessionFrames(const SessionFrames&) = delete;
  SessionFrames& operator=(const SessionFrames&) = delete;

  // In the order taken; empty if there is no such pose. Throws ConfigError if a frame's counts are
  // not of its size.
  std::vector<Exposure> Of(int pose);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gonio
