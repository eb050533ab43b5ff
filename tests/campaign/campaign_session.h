// SPDX-License-Identifier: Apache-2.0
// One session in which anything may go wrong, drawn from a seed, and what may never come of it.

#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "acquisition/session.h"

namespace gonio {

struct CampaignResult {
  SessionOutcome outcome = SessionOutcome::kComplete;
  bool resumed = false;  // it was not complete, and went on in another process until it was
  std::map<std::string, int> events;  // kinds in the log
  int poses = 0;
  long calls = 0;                       // of devices
  int faults = 0;                       // calls that were made to fail
  int starts = 0;                       // of moves and homings
  long looks = 0;                       // at the arms' true places while they could move
  std::vector<std::string> violations;  // what may never be, one line each
};

// A simulated rig of some kind, with arms that can touch or without, a planner, a sample, failure
// policies, interlocks, a lamp, a user and a disk, all drawn from `seed`.
CampaignResult RunCampaignSession(std::uint64_t seed);

}  // namespace gonio
