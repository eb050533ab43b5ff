// SPDX-License-Identifier: Apache-2.0
// The loop: ask the planner, measure, keep the raw record, reduce, tell the planner.

#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "acquisition/event_log.h"
#include "acquisition/failure_policy.h"
#include "acquisition/interlocks.h"
#include "acquisition/measure.h"
#include "acquisition/rig.h"
#include "acquisition/session_state.h"
#include "brdf/brdf.h"
#include "core/clock.h"
#include "planner/planner.h"

namespace gonio {

struct SessionOptions {
  // > 0, relative: where the last pose, measured again after a resume, differs by more than this
  // and by more than four of its sigmas, something has changed and the session ends.
  double max_reference_change = 0.1;
  // Whether a session that ends cleanly leaves the arms at RigConfig::motion.park, which it then
  // needs. Arms that were stopped at once stay where they are, and so does a rig with a fault.
  bool park = false;

  // Throws ConfigError naming the option.
  void Check() const;
};

// What a user may ask for while it runs. Tokens may be triggered from any thread.
struct SessionStop {
  std::stop_token after_pose;  // finish the pose, then end
  std::stop_token now;         // stop the arms at once; the pose is lost
  // Asked between poses, in the session's thread: whether to pause, and then, or when a failure
  // calls for a person, a call that returns when the session is to go on, or one of the tokens was
  // triggered. Arms and light stay as they are: a lamp that cools down would have to warm up again.
  // Without `wait` nobody can be called, and the session ends.
  std::function<bool()> pause = {};
  std::function<void()> wait = {};
};

struct SessionSoFar;

// Something out of the ordinary: what is said to a person who is not there.
struct SessionNotice {
  std::string kind;  // as in the log: "suspended", "failure", "person_called", "session_end", ...
  std::string message;
};

// What a session needs; everything must outlive it.
struct SessionParts {
  const RigConfig& rig;
  Devices& devices;
  Clock& clock;
  Planner& planner;
  EventLog* log = nullptr;                     // nullptr: nothing is kept (`gonio simulate`)
  const Calibrations* calibrations = nullptr;  // nullptr: the rig's numbers are all that is known
  // Another process began it: the planner has been told of all its poses, the clock goes on where
  // its log ends. nullptr: it begins.
  const SessionSoFar* so_far = nullptr;
  Interlocks* interlocks = nullptr;  // nullptr: there are none
  // Told a number before every pose, and no number twice: a simulated rig draws its noise by it
  // (SimDevices::draw).
  std::function<void(std::uint64_t)> draw = {};
  // Closes the devices of a class that failed, kInstrument or kAxis, and opens them in `devices`
  // anew; what is there is null if that fails. Empty: what is disconnected stays so.
  std::function<Result<void>(FailureClass)> reopen = {};
  // In the session's thread, as the next.
  std::function<void(const SessionNotice&)> on_event = {};
  // Told of every change of state, in the session's thread.
  std::function<void(SessionState)> on_state = {};
};

enum class SessionOutcome {
  kComplete,       // the planner said enough
  kStopped,        // the user asked
  kDeviceFault,    // a device failed; the arms have been told to stop
  kStorageFailed,  // the log refused; what it holds is whole
  kEmergencyStop,  // somebody pressed one
};

// "complete", "stopped", "device fault", "storage failed", "emergency stop": as in the log.
const char* ToString(SessionOutcome outcome);
// Not as the user or the plan wanted it.
bool IsFault(SessionOutcome outcome);

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
  Seconds exposing{0};     // of it: exposures and their read-out, changes of colour
  std::vector<SessionPose> poses;
  int reference_visits = 0;
  bool clean_up_failed = false;           // the light may still be on, or an axis move
  Gain gain;                              // of the instrument at the end; 1 without visits
  std::vector<std::string> warnings;      // one line each
  std::optional<double> predicted_error;  // the planner's, at the end

  std::vector<BrdfSample> Samples() const;
};

// How far an earlier process came; acquisition/session_history.h makes it of a log.
struct SessionSoFar {
  SessionSummary summary;
  int turns = 0;                          // poses asked for, refused ones included
  int rejections_in_a_row = 0;            // up to the last turn
  std::optional<MeasurerState> measurer;  // after the last turn; empty: there was none
  std::vector<LoggedVisit> visits;        // to the reference pose of RigConfig::drift
  std::optional<DirectionPair> first;     // the first measured pose, as it was planned
  // The last measured pose, to be measured again.
  struct Reference {
    int pose = 0;
    AxisPositions arms{};  // MeasurerState::told after it
    int frames = 1;
    BrdfSample before;
  };
  std::optional<Reference> reference;
};

// Runs a session on opened devices. Blocks until it ends; ends for every reason with the light off,
// and for every reason but kComplete and kStopped-after-a-pose with StopAll().
//
// Promises, checked in tests/scenario/:
//
//   1. Nothing moves while a frame is exposed, and nothing is exposed while an axis moves.
//   2. The raw record of a pose is durable in the log before planner.Observe() hears of it.
//   3. What fails is tried again, skipped, shown to a person, or the end, as RigConfig::failures
//   has
//      it; a pose that is skipped goes to planner.Reject() and into the log.
//   4. Once the log fails, no further pose is measured and the planner learns nothing more.
//   5. The same rig, devices, planner and clock give the same poses, with or without a log.
//   6. A session that was killed and goes on makes the same choices as one that was not, given the
//      same observations.
//   7. A pose during which an interlock tripped is discarded and measured again; one that needs no
//      device to be looked at stops arms on their way. After that, and after a failure, the session
//      makes the same choices as if nothing had happened, given the same observations.
//   8. With RigConfig::drift samples are divided by the gain that the visits to the reference
//      before them tell; the visits are in the log and no samples.
//
// One thread.
SessionSummary RunSession(const SessionParts& parts, const SessionOptions& options,
                          const SessionStop& stop = {}, const ProgressFunction& progress = {});

}  // namespace gonio
