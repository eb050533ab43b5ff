// SPDX-License-Identifier: Apache-2.0
// A session from its first move to its fit, as a user sees it.

#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "acquisition/calibration/calibrations.h"
#include "acquisition/event_log.h"
#include "acquisition/session.h"
#include "apps/gonio/build_rig.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/session_setup.h"

namespace gonio {

// Everything must outlive the call; the devices are closed by it.
struct DriveParts {
  const SessionSetup& setup;
  OpenedRig& rig;
  const Calibrations& calibrations;
  Planner& planner;
  EventLog& log;
  std::uint64_t seed = 1;                // of what is simulated
  const SessionSoFar* so_far = nullptr;  // of a session that goes on
};

// What the command line says of how it is driven.
struct DriveOptions {
  SessionOptions session;
  std::string notify;  // a command; empty: none
  bool quiet = false;
};
// Throws ConfigError: the rig has nowhere to park.
DriveOptions DriveOptionsOf(const RunOptions& options, const RigConfig& rig);

// Measures, prints what came of it, fits, and writes DIR/fit.yaml and DIR/wire.log. Returns the
// exit code. Throws std::runtime_error if what was measured cannot be fitted.
int DriveSession(const DriveParts& parts, const DriveOptions& options,
                 const std::filesystem::path& dir);

}  // namespace gonio
