// SPDX-License-Identifier: Apache-2.0
// What a session's report is made from: read, fitted and compared, but not yet drawn.

#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/rig.h"
#include "acquisition/session_record.h"
#include "acquisition/time_estimate.h"
#include "apps/gonio/report_incidents.h"
#include "brdf/brdf.h"
#include "fitting/fit.h"
#include "planner/plan.h"

namespace gonio {

struct ErrorPoint {
  int poses = 0;
  double error = 0;
};

// A pose the rig or the camera refused.
struct Refusal {
  HalfDiff angles;
  std::string message;
};

// Where a session's time went.
struct SessionTimes {
  Seconds homing{0};
  Seconds travel{0};
  Seconds settling{0};
  Seconds exposing{0};  // frames and their read-out
  Seconds other{0};     // refused poses, mostly
  Seconds total{0};
  Seconds exposing_per_pose{0};  // frames and their read-out
};

// What the rig's costs (acquisition/session_costs.h) say of the poses, after the fact.
struct PredictedTimes {
  int poses = 0;         // but the first, which comes from home
  Seconds predicted{0};  // moves, settling, exposures as one wanted
  Seconds actual{0};
  Seconds rms{0};  // of a pose's difference
};

struct ReportFacts {
  std::filesystem::path dir;
  SessionRecord session;
  Plan plan;
  RigConfig rig;  // default for imported samples, as the two estimates below are
  std::vector<Refusal> refusals;
  std::vector<std::string> device_errors;
  std::vector<Incident> incidents;
  SessionTimes times;
  PredictedTimes predicted_times;
  TimeEstimate dense;    // the same rig, at the session's mean exposure
  TimeEstimate thinned;  // 30 % of its rows

  std::optional<DsbrdfFit> fit;
  std::string no_fit;  // why not
  std::unique_ptr<Brdf> truth;
  std::string no_truth;                   // why not
  std::optional<double> male;             // of the fit against the truth
  std::vector<ErrorPoint> true_error;     // MALE of fits to the first poses
  std::string no_true_error;              // why it is not, or not wholly, there
  std::vector<ErrorPoint> planner_error;  // what the planner expected, after so many poses
};

// Takes a second or two, most of it for `true_error`. Throws ConfigError if `dir` is not a session,
// or not sound; a truth that has moved and a fit that cannot be made are facts, not errors.
ReportFacts GatherFacts(const std::filesystem::path& dir);

// The half/difference angles of a measured pose, as read back.
HalfDiff AnglesOf(const MeasuredPose& pose);

// Channels (of all poses) that saturated in every frame and so gave no reading.
int LostReadings(const SessionRecord& session);

}  // namespace gonio
