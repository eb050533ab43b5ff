// SPDX-License-Identifier: Apache-2.0
// A session from its first move to its fit, as a user sees it.

#pragma once

#include <filesystem>

#include "acquisition/calibration/calibrations.h"
#include "acquisition/event_log.h"
#include "acquisition/session.h"
#include "apps/gonio/build_rig.h"
#include "apps/gonio/session_setup.h"

namespace gonio {

// Everything must outlive the call; the devices are closed by it.
struct DriveParts {
  const SessionSetup& setup;
  OpenedRig& rig;
  const Calibrations& calibrations;
  Planner& planner;
  EventLog& log;
  const SessionSoFar* so_far = nullptr;  // of a session that goes on
};

// Measures, prints what came of it, fits, and writes DIR/fit.yaml and DIR/wire.log. Returns the
// exit code. Throws std::runtime_error if what was measured cannot be fitted.
int DriveSession(const DriveParts& parts, const SessionOptions& options,
                 const std::filesystem::path& dir, bool quiet);

}  // namespace gonio
