// SPDX-License-Identifier: Apache-2.0
// How fast the axes really are, and what each pose and frame costs beside: from sessions' logs.

#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "acquisition/radiometry/measured_value.h"
#include "acquisition/rig.h"
#include "acquisition/session_record.h"
#include "core/error.h"

namespace gonio {

inline constexpr const char* kTimeFile = "time.yaml";

// All axes at once, from standing still to standing still.
struct LoggedMove {
  AxisPositions way{};  // rad, signed
  Seconds time{0};
};

// From start to end, beside moving, settling, exposures and the camera's read-out.
struct LoggedPose {
  int frames = 0;
  Seconds spare{0};
};

struct LoggedTimes {
  std::vector<LoggedMove> moves;
  std::vector<LoggedPose> poses;
};

// Adds a session's. Moves that were repeated, the first, and those after a refused pose are left
// out: where they began is not in the log.
void AddTimes(const SessionRecord& session, const RigConfig& rig, LoggedTimes& times);

struct TimeFit {
  std::array<MeasuredValue, kAxes> max_speed{};      // rad/s
  std::array<MeasuredValue, kAxes> acceleration{};   // rad/s^2
  std::array<MeasuredValue, kAxes> move_overhead{};  // s
  std::array<int, kAxes> decided{};                  // moves for which an axis was the slowest
  MeasuredValue pose_overhead;                       // s
  MeasuredValue frame_overhead;                      // s
  int moves = 0;
  double believed_rms = 0;  // s, of a move's predicted time, by the rig file
  double fitted_rms = 0;    // s, and by the fit

  TimeModel Model() const;
};

inline constexpr int kLeastMoves = 10;

// A move takes as long as the slowest axis (docs/geometry.md, "Travel time"). What moves leave
// open stays as the rig file has it: its speeds and accelerations are believed to within a factor
// of 1.65 (one sigma), its overheads to within half a second. kRefused: fewer than kLeastMoves.
Result<TimeFit> FitTimes(const RigConfig& rig, const LoggedTimes& times);

// Throws std::runtime_error or ConfigError naming file, line and key.
void WriteTimes(const std::filesystem::path& path, const TimeFit& fit,
                std::span<const char* const> axes, std::int64_t now);
// `axes`: of the rig that it is read for; the names in the file must be theirs.
TimeModel ReadTimes(const std::filesystem::path& path, std::span<const char* const> axes);

}  // namespace gonio
