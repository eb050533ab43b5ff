// SPDX-License-Identifier: Apache-2.0
// When a session goes back to its reference pose, and what it makes of it (acquisition/drift.h).

#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "acquisition/drift.h"
#include "acquisition/measure.h"
#include "acquisition/radiometry.h"

namespace gonio {

// One visit, as the event log keeps it.
struct ReferenceRecord {
  int visit = 0;                  // 1, 2, ...
  int poses = 0;                  // measured before it
  PoseRecord record;              // its frames are not kept, but what they came to
  std::vector<Rgb> net;           // of each frame: mean counts above black over the region
  ReferenceVisit read;            // before any correction
  Rgb ratio = Rgb::Ones();        // of `read` to the first visit's, as it is
  Rgb ratio_sigma = Rgb::Zero();  // of the noise of both
  Gain gain;                      // now, given all visits
};

// A visit as the log has it: all that later corrections depend on.
struct LoggedVisit {
  int poses = 0;                       // measured before it
  Seconds time{0};                     // when it ended
  std::optional<ReferenceVisit> read;  // empty: it was refused
};

// Corrections are made as a session runs: a sample is divided by the gain that the visits before it
// make the best guess of its time, which is that of the last one, smoothed by those before. What
// later visits say of it the log has, for later reductions. One thread.
class ReferenceVisits {
 public:
  // Keeps references; they must outlive it.
  ReferenceVisits(const RigConfig& rig, const Calibrations& calibrations)
      : rig_(rig), calibrations_(calibrations), tracker_(rig.drift.expected_per_hour) {}

  // `poses`: measured so far, the last one of `last`.
  bool Due(int poses, Seconds now) const;
  // Where to go if the rig does not say. Precondition of Visit() without DriftPolicy::pose.
  void Offer(const DirectionPair& measured) { first_ = first_.value_or(measured); }

  // Measures the reference. Errors as PoseMeasurer::Measure(); also kRefused if no channel was
  // measured. The next visit is due as if this one had gone well.
  Result<ReferenceRecord> Visit(PoseMeasurer& measurer, int poses, std::stop_token stop);

  // As if it had just made this visit.
  void Recall(const LoggedVisit& visit);

  // Divides the samples of a pose that ended at `time` by the gain, whose uncertainty is their
  // kDrift. Before the first visit they stay as they are.
  void Correct(Seconds time, std::vector<ReducedSample>* samples) const;

  // "the reference has changed by ..."; empty: not by more than DriftPolicy::max_change, by more
  // than twice what the noise could have done.
  std::string Complaint(Seconds now) const;

  int visits() const { return tracker_.visits(); }
  Gain At(Seconds time) const { return tracker_.At(time); }

 private:
  const RigConfig& rig_;
  const Calibrations& calibrations_;
  DriftTracker tracker_;
  std::optional<DirectionPair> first_;
  std::optional<ReferenceVisit> first_read_;
  int poses_then_ = 0;  // at the last visit, or attempt
  std::optional<Seconds> last_;
};

}  // namespace gonio
