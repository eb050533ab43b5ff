// SPDX-License-Identifier: Apache-2.0
// What makes a session what it is, from the user's files or from those a session has frozen.

#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/calibration/calibrations.h"
#include "acquisition/event_log.h"
#include "apps/gonio/build_rig.h"
#include "brdf/brdf.h"
#include "planner/plan.h"

namespace gonio {

// The choices; nothing else decides what a session does.
struct SessionChoice {
  std::filesystem::path rig_path;
  std::string rig_text;
  std::filesystem::path plan_path;
  std::string plan_text;
  std::string prior;                    // as SessionInfo::prior_spec
  std::filesystem::path material_path;  // empty: a real sample, and nothing to compare with
  std::uint64_t seed = 1;
  int max_poses = 0;                    // 0: the plan's
  std::filesystem::path calibration;    // folder, in place of the rig's
  bool use_calibration_of_file = true;  // of the rig file's folder, where `calibration` is empty
};

// Those of a session that was begun earlier, with the calibrations it keeps copies of.
SessionChoice ChoiceOf(const SessionInfo& info, const std::filesystem::path& session);

// Everything that is read and checked before a directory is made or an axis moves.
struct SessionSetup {
  RigFile rig;
  Plan plan;
  std::unique_ptr<Brdf> material;  // null: a real sample, and nothing to compare it with

  // What a simulated camera looks at; null for a real one.
  const Brdf* SimulatedSample() const;
  Reachable Measurable() const;
};
// Throws ConfigError.
SessionSetup SetUp(const SessionChoice& choice);

bool HasRealCamera(const RigConfig& rig);

// After Believe(), if there are calibrations: what a planner expects of the rig depends on them.
std::unique_ptr<Planner> PlannerFor(const SessionSetup& setup, std::uint64_t seed);

// `begin`: of its clock.
OpenedRig Open(const SessionSetup& setup, std::uint64_t seed, Seconds begin = Seconds(0));

// Files of the calibration folder that say where things are and how long they take.
std::vector<std::filesystem::path> FilesOfTheWhole(const RigConfig& rig);

// Those of the rig's folder, for this camera; says which they are and how old.
Calibrations LoadFor(const RigConfig& rig, const Devices& devices);

// SHA-256 of a material's file; empty for one that is a session.
std::string HashOfMaterial(const std::filesystem::path& path);

SessionInfo Describe(const SessionChoice& choice, const SessionSetup& setup,
                     const Calibrations& calibrations, const Devices& devices);

}  // namespace gonio
