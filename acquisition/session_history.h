// SPDX-License-Identifier: Apache-2.0
// What a session decided, turn by turn, and whether a planner decides the same again.

#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/session.h"
#include "acquisition/session_record.h"
#include "planner/candidates.h"
#include "planner/planner.h"

namespace gonio {

// One turn of the loop in session.cpp.
struct LoggedTurn {
  Proposal proposal;  // its directions to the log's rounding
  int pose = 0;       // 1, 2, ...; 0: it was refused
};

// All of it that later turns depend on beside what the planner was told.
struct SessionHistory {
  std::vector<LoggedTurn> turns;
  Seconds end{0};                          // of the last event
  std::optional<MeasurerState> measurer;   // after the last turn; empty before the first
  std::optional<AxisPositions> reference;  // MeasurerState::told after the last measured pose

  std::vector<LoggedVisit> visits;  // to the reference pose of RigConfig::drift

  // From `turn` on the session was run with this: first as it was begun, then whatever resumes
  // with accepted changes put in its place.
  struct Part {
    int turn = 0;
    SessionInfo info;
  };
  std::vector<Part> parts;  // not empty
};

// Without a pose that was not reduced. Throws ConfigError: the events do not fit the poses.
SessionHistory HistoryOf(const SessionRecord& record);

// Where a planner decides otherwise than the log.
struct Disagreement {
  int turn = 0;      // index into SessionHistory::turns; their number: after the last
  std::string what;  // "turn 17: the log has ..., the planner now ..."
};

// Index of a candidate with these directions; -1: there is none.
using CandidateIndex = std::function<int(const DirectionPair&)>;

// Of `candidates`, as CandidatesOf() gives them.
CandidateIndex IndexIn(std::vector<Candidate> candidates);

struct RetraceOptions {
  // Before this turn the planner may disagree: it is then told of the poses up to there as if it
  // had asked for them, where `learn`, which must be given, knows a candidate.
  int agree_from = 0;
  int end = std::numeric_limits<int>::max();  // only the turns before it
  CandidateIndex learn = {};
  // Called before each turn is told, with what is told.
  std::function<void(int turn, const Proposal&)> visit = {};
};

struct Retraced {
  SessionSoFar so_far;
  std::optional<Disagreement> first;  // empty: every decision is as it was
};

// Asks `planner`, which was just made, for every proposal and tells it what the log has, as
// RunSession() did; up to the first disagreement.
Retraced Retrace(const SessionRecord& record, const SessionHistory& history, const RigConfig& rig,
                 Planner& planner, const RetraceOptions& options = {});

}  // namespace gonio
