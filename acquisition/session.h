// SPDX-License-Identifier: Apache-2.0
// The loop: ask the planner, measure, keep the raw record, reduce, tell the planner.

#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "acquisition/event_log.h"
#include "acquisition/rig.h"
#include "brdf/brdf.h"
#include "core/clock.h"
#include "planner/planner.h"

namespace gonio {

struct SessionOptions {
  int max_rejections_in_a_row = 10;  // >= 1: more, and the rig is taken to be broken

  // Throws ConfigError naming the option.
  void Check() const;
};

// Two ways to ask for an end. Both may be triggered from any thread.
struct SessionStop {
  std::stop_token after_pose;  // finish the pose, then end
  std::stop_token now;         // stop the arms at once; the pose is lost
};

// What a session needs; everything must outlive it.
struct SessionParts {
  const RigConfig& rig;
  Devices& devices;
  Clock& clock;
  Planner& planner;
  EventLog* log = nullptr;                     // nullptr: nothing is kept (`gonio simulate`)
  const Calibrations* calibrations = nullptr;  // nullptr: the rig's numbers are all that is known
};

enum class SessionOutcome {
  kComplete,       // the planner said enough
  kStopped,        // the user asked
  kDeviceFault,    // a device failed; the arms have been told to stop
  kStorageFailed,  // the log refused; what it holds is whole
};

// "complete", "stopped", "device fault", "storage failed": as in the log.
const char* ToString(SessionOutcome outcome);

// After every measured or rejected pose.
struct Progress {
  int poses = 0;
  int max_poses = 0;  // at most
  int rejected = 0;
  Seconds elapsed{0};                     // session clock, homing included
  std::optional<double> predicted_error;  // the planner's
};
using ProgressFunction = std::function<void(const Progress&)>;

// One pose the session got, as the planner saw it.
struct SessionPose {
  std::vector<BrdfSample> samples;        // the proposed pose's first
  Seconds end{0};                         // session clock
  std::optional<double> predicted_error;  // of the planner's last fit before it
};

struct SessionSummary {
  SessionOutcome outcome = SessionOutcome::kComplete;
  std::string reason;  // one line: the planner's, the user's, or the error's
  int rejected = 0;
  int frames = 0;
  Seconds duration{0};     // session clock, from the first home to the last exposure
  Seconds preparation{0};  // of it: homing
  Seconds travel{0};       // of it: axes moving
  Seconds exposing{0};     // of it: exposures and their read-out
  std::vector<SessionPose> poses;
  int reference_visits = 0;
  Gain gain;                              // of the instrument at the end; 1 without visits
  std::vector<std::string> warnings;      // one line each
  std::optional<double> predicted_error;  // the planner's, at the end

  std::vector<BrdfSample> Samples() const;
};

// Runs a session on opened devices. Blocks until it ends; ends for every reason with the light off,
// and for every reason but kComplete and kStopped-after-a-pose with StopAll().
//
// Promises, checked in tests/scenario/:
//
//   1. Nothing moves while a frame is exposed, and nothing is exposed while an axis moves.
//   2. The raw record of a pose is durable in the log before planner.Observe() hears of it.
//   3. A pose that is refused (kRefused) goes to planner.Reject() and into the log, and the session
//      goes on; any other error ends it.
//   4. Once the log fails, no further pose is measured and the planner learns nothing more.
//   5. The same rig, devices, planner and clock give the same poses, with or without a log.
//
//   6. With RigConfig::drift samples are divided by the gain that the visits to the reference
//   before
//      them tell; the visits are in the log and no samples.
//
// One thread.
SessionSummary RunSession(const SessionParts& parts, const SessionOptions& options,
                          const SessionStop& stop = {}, const ProgressFunction& progress = {});

}  // namespace gonio
