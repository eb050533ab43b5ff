// SPDX-License-Identifier: Apache-2.0
// Coarse to fine, and within a level wherever the arms get soonest.

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planner/candidates.h"
#include "planner/planner.h"

namespace gonio {

struct HierarchicalOptions {
  int max_poses = 0;  // >= 0; 0: all candidates
};

// The candidates' raster as nested levels: the first has every s-th row and column, s the power of
// two that leaves two to four of each; each later level halves the step of the rows, then of the
// columns, in turn, and holds what is new. A level is finished before the next begins; within one
// the next pose is the one that is reached soonest from where the arms stand, the lower index if
// two are as near. A level the budget does not cover is thinned evenly, so that the last poses are
// not all in one corner.
//
// Nothing depends on the readings: the rival that spends its time well instead of choosing well.
// Proposal::score is minus the seconds of the move.
class HierarchicalPlanner final : public Planner {
 public:
  // `travel`: if empty, the larger of the angles between the two light and the two detector
  // directions stands for the time. Precondition: candidates is not empty.
  HierarchicalPlanner(std::vector<Candidate> candidates, const HierarchicalOptions& options,
                      TravelTime travel);

  std::optional<Proposal> Next() override;
  void Observe(const Proposal& proposal, const BrdfSample& sample) override;
  void Reject(const Proposal& proposal) override;
  std::string reason() const override { return reason_; }
  int MaxPoses() const override { return max_poses_; }

 private:
  void FillLevels();
  std::vector<int> Thin(const std::vector<int>& level) const;
  Proposal Cheapest() const;

  std::vector<Candidate> candidates_;
  TravelTime travel_;
  int max_poses_;
  std::vector<std::vector<int>> levels_;  // indices into candidates_, coarse to fine
  std::size_t level_ = 0;                 // the one being measured
  std::vector<int> left_;                 // of that level
  int measured_ = 0;
  std::optional<DirectionPair> at_;  // the last pose measured
  std::optional<Proposal> current_;
  std::string reason_;
};

}  // namespace gonio
