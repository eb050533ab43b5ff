// SPDX-License-Identifier: Apache-2.0
// Moves the arms over the poses of a target, takes an image at each and keeps what it showed.

#pragma once

#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "acquisition/geometry_calibration/bundle.h"
#include "acquisition/rig.h"
#include "core/clock.h"

namespace gonio {

// Per pose: its number, of how many, and what was seen ("54 corners", "no board", ...).
using TargetProgress = std::function<void(int, int, const std::string&)>;

// A rig with its opened devices; everything must outlive it.
struct TargetSession {
  const RigConfig& rig;
  Devices& devices;
  Clock& clock;
  std::stop_token stop{};
  TargetProgress progress{};
};

// Homes, switches the light on, visits BoardPoses() or MirrorPoses(). Poses where the target is not
// seen are passed over. Ends with the light off. kRefused: no exposure suits; too few poses are in
// reach, or show the target (with the count). Any other error is a device's, which ends it.
Result<std::vector<BoardView>> PhotographBoard(const TargetSession& session,
                                               const Checkerboard& board);
Result<std::vector<MirrorView>> PhotographMirror(const TargetSession& session);

// What was seen of both, as DIR/geometry-views.json: measured once, fitted as often as liked.
struct TargetViews {
  Checkerboard board;
  std::string camera;  // Camera::identity()
  std::vector<BoardView> boards;
  std::vector<MirrorView> mirrors;
};
inline constexpr const char* kViewsFile = "geometry-views.json";
// Whole or not at all. Throws std::runtime_error.
void WriteViews(const std::filesystem::path& path, const TargetViews& views);
// Throws ConfigError "PATH: ...".
TargetViews ReadViews(const std::filesystem::path& path);

}  // namespace gonio
