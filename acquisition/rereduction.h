// SPDX-License-Identifier: Apache-2.0
// Samples anew, from the frames a session kept.

#pragma once

#include <filesystem>
#include <vector>

#include "acquisition/calibration/calibrations.h"
#include "acquisition/kinematics.h"
#include "acquisition/radiometry.h"
#include "acquisition/reference_visits.h"
#include "acquisition/rig.h"
#include "acquisition/session_frames.h"
#include "acquisition/session_record.h"

namespace gonio {

// Reduce() of poses that were measured before. With the rig and the calibrations of the session it
// gives its samples to the last bit. One thread.
class Rereduction {
 public:
  // Keeps references. `visits`: to the reference pose, as SessionHistory has them; samples are
  // corrected by those before them. Throws ConfigError as SessionFrames.
  Rereduction(const std::filesystem::path& session, const RigConfig& rig,
              const Calibrations& calibrations, std::vector<LoggedVisit> visits);

  // What Measure() had returned.
  PoseRecord RecordOf(const MeasuredPose& pose);
  // Errors: as Reduce().
  Result<std::vector<ReducedSample>> Of(const MeasuredPose& pose);

 private:
  const RigConfig& rig_;
  const Calibrations& calibrations_;
  const std::vector<LoggedVisit> visits_;
  const Kinematics kinematics_;
  SessionFrames frames_;
};

}  // namespace gonio
