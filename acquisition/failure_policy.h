// SPDX-License-Identifier: Apache-2.0
// What a session does when something fails: try again, skip the pose, call a person, or stop.

#pragma once

#include "core/clock.h"
#include "core/config.h"

namespace gonio {

// By what has to be done before the next attempt.
enum class FailureClass {
  kPose,        // the pose was refused (ErrorCode::kRefused); the devices are well
  kInstrument,  // camera, light or monitor: opened anew, the arms stay where they are
  kAxis,        // an axis: opened anew, and all axes are homed, from wherever they stopped
};
// "pose", "instrument", "axis": as in rig files and in the log.
const char* ToString(FailureClass failure);

// Once it was tried again in vain.
enum class FailureAction {
  kSkip,   // the pose is refused, and the session goes on
  kPause,  // until a person has looked at it; then it is tried again
  kStop,   // the session ends
};

struct FailurePolicy {
  int retries = 0;  // >= 0, of the same pose
  Seconds wait{0};  // >= 0, before each; of a pose: none
  FailureAction then = FailureAction::kStop;
};

struct FailuresConfig {
  FailurePolicy pose{.retries = 0, .wait = Seconds(0), .then = FailureAction::kSkip};
  FailurePolicy instrument{.retries = 3, .wait = Seconds(10), .then = FailureAction::kStop};
  // None by itself: homing sweeps whole ranges, and nobody knows where the arms stopped.
  FailurePolicy axis{.retries = 0, .wait = Seconds(10), .then = FailureAction::kStop};
  int max_in_a_row = 10;  // >= 1: so many failures with no pose measured between end the session

  const FailurePolicy& Of(FailureClass failure) const;
};

// The `failures` mapping of a rig file; without one: as above. Throws ConfigError.
FailuresConfig ReadFailures(const ConfigNode& root);

// Counts failures and says what to do about each. One thread.
class FailureBook {
 public:
  enum class Verdict { kRetry, kSkip, kPause, kStop };

  // `in_a_row`: those of an earlier process.
  FailureBook(const FailuresConfig& config, int in_a_row) : config_(config), in_a_row_(in_a_row) {}

  // Another failure. kStop, too, where there were too many in a row.
  Verdict Next(FailureClass failure);
  // The pose is done with: skipped, or a person has looked. Attempts are counted anew.
  void Closed() { attempts_ = 0; }
  void Measured() { attempts_ = in_a_row_ = 0; }

  bool TooMany() const { return in_a_row_ >= config_.max_in_a_row; }
  int in_a_row() const { return in_a_row_; }

 private:
  const FailuresConfig& config_;
  int in_a_row_;
  int attempts_ = 0;
};

}  // namespace gonio
