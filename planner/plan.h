// SPDX-License-Identifier: Apache-2.0
// Plan files, and the planners they describe.

#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "fitting/fit.h"
#include "fitting/prior.h"
#include "planner/candidates.h"
#include "planner/planner.h"

namespace gonio {

// A plan file such as configs/plan-information.yaml, checked.
struct Plan {
  std::string kind;  // "grid", "random", "information"
  std::string text;  // the file as it was read, frozen into the session
  int max_poses = 0;
  Prior prior;  // for the planner's own fit and for the session's final one
  FitOptions fit;
  CandidateOptions candidates;
  // ... more, private to the planner module
};

// Throws ConfigError naming file, line and key.
Plan LoadPlan(const std::filesystem::path& path);
Plan ParsePlan(const std::string& text, const std::string& name);

// Throws ConfigError if `reachable` leaves no candidate.
std::unique_ptr<Planner> MakePlanner(const Plan& plan, const Reachable& reachable,
                                     std::uint64_t seed);

}  // namespace gonio
