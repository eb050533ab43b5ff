// SPDX-License-Identifier: Apache-2.0
// Planners whose list of poses is known before the first measurement.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "planner/candidates.h"
#include "planner/planner.h"

namespace gonio {

// Proposes candidates in a fixed order; rejected and measured ones are simply passed.
class SequencePlanner final : public Planner {
 public:
  // `order`: indices into `candidates`, each at most once. `label`: Proposal::reason of each pose.
  SequencePlanner(std::vector<Candidate> candidates, std::vector<int> order, std::string label);

  std::optional<Proposal> Next() override;
  void Observe(const Proposal& proposal, const BrdfSample& sample) override;
  void Reject(const Proposal& proposal) override;
  std::string reason() const override { return "every planned pose was visited"; }
  int MaxPoses() const override { return static_cast<int>(order_.size()); }

 private:
  std::vector<Candidate> candidates_;
  std::vector<int> order_;
  std::vector<bool> spent_;  // measured or rejected
  std::string label_;
  std::size_t next_ = 0;
};

struct RasterOptions {
  int every_theta_h = 1;  // > 0: keep every k-th row, as Edahiro et al. thin theta_h
  int every_theta_d = 1;  // > 0: keep every k-th column
  int max_poses = 0;      // > 0: instead, a coarser raster over the same range with at most so many
};

// The raster, row by row and to and fro, as anyone would scan. With a budget: the r x c raster (r c
// <= budget, as square as it goes) whose cells' centres are nearest to candidates.
std::vector<int> RasterOrder(const std::vector<Candidate>& candidates,
                             const CandidateOptions& raster, const RasterOptions& options);

// `count` different candidates, drawn uniformly (all of them, shuffled, if there are fewer).
std::vector<int> RandomOrder(std::size_t candidates, int count, std::uint64_t seed);

}  // namespace gonio
