// SPDX-License-Identifier: Apache-2.0
// The event log: DIR/session.sqlite, the only memory of a session (docs/data-format.md).

#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/measure.h"
#include "acquisition/radiometry.h"
#include "acquisition/reference_visits.h"
#include "brdf/brdf.h"
#include "core/clock.h"
#include "core/error.h"
#include "planner/planner.h"

namespace gonio {

// Versions of the tables of DIR/session.sqlite: what is written, the oldest that is gone on with,
// and the oldest that is read. The second one says more of each frame, the third of each sample's
// uncertainty, the fourth which colour of the light lit a frame (docs/data-format.md).
inline constexpr int kSessionFormat = 4;
inline constexpr int kOldestResumedFormat = 3;
inline constexpr int kOldestSessionFormat = 1;
inline constexpr const char* kSessionFile = "session.sqlite";
inline constexpr const char* kSessionCalibration = "calibration";  // folder in it

// What is frozen when a session starts. Hashes are SHA-256, in hexadecimal, and are filled in by
// EventLog::Create() for the two texts.
struct SessionInfo {
  std::string gonio_version;
  std::string created_utc;  // "2024-05-01T12:00:00Z"; filled in by Create() if empty
  std::uint64_t seed = 0;
  int max_poses = 0;  // in place of the plan's; 0: the plan's
  std::string rig_name;
  std::string rig_path;  // absolute; empty in older sessions
  std::string rig_text;  // the rig file as it was read
  // Of the rig's axes, in order; not in `meta`, but in the names of columns.
  std::vector<std::string> axes{std::begin(kAxisNames), std::end(kAxisNames)};
  std::string plan_path;  // absolute: prior files named in a plan stand beside it
  std::string plan_text;  // the plan file as it was read
  std::string prior_name;
  std::string prior_spec;  // empty: the plan's; "none"; "generic"; or a prior file's absolute path
  std::string prior_sha256;     // of its numbers
  std::string material_path;    // the simulated sample's file, absolute; empty for a real sample
  std::string material_sha256;  // of that file
  // Calibrations the samples were reduced with, copied into DIR/calibration/: file name -> SHA-256.
  std::map<std::string, std::string> calibrations;
  std::map<std::string, std::string> devices;  // role -> identity, e.g. "camera" -> "sim-camera"
  // Where somebody else's samples are from (acquisition/import_session.h); empty: measured by us.
  // If not, rig_text is empty: nobody knows the rig.
  std::map<std::string, std::string> imported;
};

// How one pose went, as the log needs it beside the raw record.
struct PoseNote {
  int pose = 0;  // 1, 2, ... in the order measured
  Proposal proposal;
  std::optional<double> predicted_error;  // the planner's, from the poses before this one
  MeasurerState after;
};

// A pose that was refused.
struct RejectionNote {
  Proposal proposal;
  Error error;
  MeasurerState after;
};

// A session goes on in another process.
struct ResumeNote {
  std::string gonio_version;
  int poses = 0;                     // measured before
  std::vector<std::string> changes;  // what the user accepted, a line each; empty: all is as it was
  std::map<std::string, std::string> now;  // what of `meta` is another from now on
};

// The last measured pose, measured again after a resume.
struct ReferenceNote {
  int pose = 0;
  BrdfSample before;
  BrdfSample now;
  double change = 0;        // relative, of the best channel's f_r
  double sigma_change = 0;  // of its noise
};

// How a session ended.
struct SessionEnd {
  std::string outcome;  // "complete", "stopped", "device fault", "storage failed"
  std::string reason;
  int poses = 0;
  int rejected = 0;
  Seconds duration{0};
  std::optional<double> predicted_error;  // the planner's, from all poses
};

// Writes a session. Nothing in it is ever changed again: triggers refuse UPDATE and DELETE.
//
// Promises, checked by tests/scenario/event_log_test.cpp:
//
//   1. When a method returns success, what it wrote survives SIGKILL and power loss (WAL with
//      synchronous=FULL); when it returns an error, nothing of it is in the log.
//   2. AppendPose() is one transaction: the pose, its exposures and the event, or none of them.
//   3. Create() leaves nothing behind when it fails.
//
// One thread. Errors: kStorage "DIR/session.sqlite: cannot write: REASON" (disk full, I/O error);
// the log is unchanged and the session must end, since nothing more can be kept.
class EventLog {
 public:
  // Makes DIR, which must not exist, and the file in it. Throws ConfigError "DIR: exists already;
  // ..." or std::runtime_error "DIR/session.sqlite: cannot write: ...".
  // Until it is destroyed no other process can open the session to write.
  static EventLog Create(const std::filesystem::path& dir, SessionInfo info);

  EventLog(EventLog&&) noexcept;
  EventLog& operator=(EventLog&&) noexcept;
  // Opens a session to go on with it; one of an older format that can be gone on with becomes one
  // of this. Throws ConfigError: it is none, is of another format, is
  // damaged (FindDamage in acquisition/session_check.h says how), or another process has it open.
  static EventLog Open(const std::filesystem::path& dir);

  // Folds the write-ahead log into the one file.
  ~EventLog();

  // The raw record of a pose, before anything learns from it.
  Result<void> AppendPose(const PoseNote& note, const PoseRecord& record);
  // What Reduce() made of it at `time`. Precondition: AppendPose() of the same pose.
  Result<void> AppendSamples(int pose, Seconds time, const std::vector<ReducedSample>& samples);
  Result<void> AppendRejection(Seconds time, const RejectionNote& note);
  Result<void> AppendResume(Seconds time, const ResumeNote& note);
  Result<void> AppendResumeReference(Seconds time, const ReferenceNote& note);
  // A visit to the reference pose (acquisition/drift.h): no pose of the session.
  Result<void> AppendReference(const ReferenceRecord& visit, const MeasurerState& after);
  Result<void> AppendError(Seconds time, const Error& error);
  // Anything else that happened: one word and one line.
  Result<void> AppendNote(Seconds time, const std::string& kind, const std::string& message);
  Result<void> AppendEnd(Seconds time, const SessionEnd& end);

  // All that `append` appends to this log, or none of it, in one transaction: where nothing is
  // measured that could be lost, thousands of poses need not each wait for the disk.
  Result<void> AppendTogether(const std::function<Result<void>()>& append);

  const std::filesystem::path& file() const;

 private:
  struct Impl;
  explicit EventLog(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace gonio
