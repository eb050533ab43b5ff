// SPDX-License-Identifier: Apache-2.0
// Reads DIR/session.sqlite, finished or not.

#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/event_log.h"

namespace gonio {

// One measured pose with what was made of it.
struct MeasuredPose {
  int pose = 0;  // 1, 2, ...
  int candidate = 0;
  std::string reason;
  std::optional<double> score;  // what the planner maximised; empty if it was not finite
  HalfDiff planned;
  // As they were when the planner learned of them, to the last bit; empty only in `unreduced`. The
  // first is that of the pose, the others are what else its image shows.
  std::vector<BrdfSample> samples;
  // Of each sample: standard uncertainty that all samples share, 1/sr; BrdfSample::sigma is what
  // they do not. Zero in formats before the third, infinite where nothing was measured.
  std::vector<Rgb> systematic;
  int frames = 0;
  int frames_wanted = 1;  // usable ones, by the planner
  int move_retries = 0;
  AxisPositions commanded{};
  AxisPositions readback{};  // encoders, after settling
  Seconds start{0};          // session clock
  Seconds move_time{0};
  Seconds end{0};
  Seconds exposed{0};                     // sum of the frames' exposures, without read-out
  std::optional<double> predicted_error;  // the planner's, from the poses before this one
};

struct SessionEvent {
  int seq = 0;
  Seconds time{0};
  std::string kind;
  std::string body;  // JSON
};

struct SessionRecord {
  SessionInfo info;
  std::vector<MeasuredPose> poses;              // those with a sample, in order
  std::optional<MeasuredPose> unreduced;        // the last pose, if only its frames were kept
  std::map<std::string, int> frames_by_colour;  // of the light, if it has colours
  std::vector<SessionEvent> events;             // in order
  std::optional<SessionEnd> end;                // empty: still running, or killed

  std::vector<BrdfSample> Samples() const;
};

// `info` with what a resume has changed; `body`: of its event.
SessionInfo InfoAfter(const SessionInfo& info, const std::string& body);
// After all of them.
SessionInfo LatestInfo(const SessionRecord& record);

// Whether `path` is a directory that holds a session's file.
bool IsSession(const std::filesystem::path& path);

// Throws ConfigError "DIR: is not a session: ..." unless it looks like one from outside.
void CheckSession(const std::filesystem::path& dir);

// Opens read-only, checks that it is a session of our version and that the file is sound, reads
// and closes. Throws ConfigError "DIR: is not a session: ...".
SessionRecord ReadSession(const std::filesystem::path& dir);

}  // namespace gonio
