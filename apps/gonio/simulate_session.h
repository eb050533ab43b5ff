// SPDX-License-Identifier: Apache-2.0
// One simulated session: what a plan costs and brings on a material.

#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "acquisition/session.h"
#include "apps/gonio/build_rig.h"
#include "planner/plan.h"

namespace gonio {

struct NamedPlan {
  std::string name;
  Plan plan;
};

struct NamedMaterial {
  std::string name;
  std::shared_ptr<const Brdf> brdf;
  bool drawn = false;  // from a prior, not from a file
};

// When a session's error fell to the target.
struct Reached {
  double poses = 0;  // interpolated where the true error is meant
  Seconds after{0};  // session clock, homing included
};

struct SimulatedSession {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  std::string plan, material, prior;
  std::uint64_t seed = 1;
  int poses = 0;
  int rejected = 0;
  Seconds duration{0};
  Seconds exposing_per_pose{0};
  double male = kUnknown;  // unless complete, with a pose
  std::optional<double> predicted_error{};
  std::string reason{};
  SessionOutcome outcome = SessionOutcome::kComplete;
  // Empty: not within the budget, or there is no target.
  std::optional<Reached> by_predicted{};  // where the planner would have stopped
  std::optional<Reached> by_true{};       // where the fit was first that good
  double male_at_stop = kUnknown;         // the true error where the planner would have stopped
};

// `target`: a MALE; if > 0 the session goes on to its budget, whatever target the plan has, to find
// out when the true error gets there. That is looked at after some of the poses, each time a fifth
// more, and interpolated between as frontier studies do; of a raster, which is nothing before it is
// whole, at its end.
//
// One thread. Throws ConfigError: no pose is within reach, the samples cannot be fitted.
SimulatedSession Simulate(const RigFile& rig, const NamedPlan& plan, const NamedMaterial& material,
                          std::uint64_t seed, double target, const SessionStop& stop);

// `with_target`: also when the target was reached, null if it was not.
nlohmann::json ToJson(const SimulatedSession& session, bool with_target);

}  // namespace gonio
