// SPDX-License-Identifier: Apache-2.0
#include "planner/hierarchical_planner.h"

#include <algorithm>
#include <utility>

#include "core/check.h"

namespace gonio {
namespace {

double AngleMoved(const DirectionPair& from, const DirectionPair& to) {
  return std::max(AngleBetween(from.wi, to.wi), AngleBetween(from.wo, to.wo));
}

// One axis of the raster, thinned.
struct Axis {
  int step = 1;
  int first = 0;

  explicit Axis(int count) {
    while (step * 4 < count) step *= 2;
    first = step / 2;
  }
  bool Holds(int index) const { return index % step == first % step; }
  void Refine() { step = std::max(1, step / 2); }
};

}  // namespace

HierarchicalPlanner::HierarchicalPlanner(std::vector<Candidate> candidates,
                                         const HierarchicalOptions& options, TravelTime travel)
    : candidates_(std::move(candidates)),
      travel_(travel ? std::move(travel) : AngleMoved),
      max_poses_(static_cast<int>(candidates_.size())) {
  GONIO_CHECK(!candidates_.empty(), "a planner needs candidates");
  if (options.max_poses > 0) max_poses_ = std::min(max_poses_, options.max_poses);
  FillLevels();
  left_ = Thin(levels_[0]);
}

void HierarchicalPlanner::FillLevels() {
  int last_row = 0;
  int last_column = 0;
  for (const Candidate& candidate : candidates_) {
    last_row = std::max(last_row, candidate.row);
    last_column = std::max(last_column, candidate.column);
  }
  Axis rows(last_row + 1);
  Axis columns(last_column + 1);
  std::vector<char> assigned(candidates_.size(), false);
  for (bool rows_next = true;; rows_next = !rows_next) {
    std::vector<int> level;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (assigned[i] || !rows.Holds(candidates_[i].row)) continue;
      if (!columns.Holds(candidates_[i].column)) continue;
      assigned[i] = true;
      level.push_back(static_cast<int>(i));
    }
    if (!level.empty()) levels_.push_back(std::move(level));
    if (rows.step == 1 && columns.step == 1) return;
    (rows_next ? rows : columns).Refine();
  }
}

// As much of a level as the budget covers, spread evenly over its raster order.
std::vector<int> HierarchicalPlanner::Thin(const std::vector<int>& level) const {
  const std::size_t budget = max_poses_ - measured_;
  if (level.size() <= budget) return level;
  std::vector<int> thinned;
  for (std::size_t i = 0; i < budget; ++i) {
    thinned.push_back(level[(2 * i + 1) * level.size() / (2 * budget)]);
  }
  return thinned;
}

std::optional<Proposal> HierarchicalPlanner::Next() {
  if (current_ || !reason_.empty()) return current_;
  if (measured_ >= max_poses_) {
    reason_ = max_poses_ < static_cast<int>(candidates_.size()) ? "pose budget reached"
                                                                : "every candidate was measured";
    return std::nullopt;
  }
  while (left_.empty() && level_ + 1 < levels_.size()) left_ = Thin(levels_[++level_]);
  if (left_.empty()) {
    reason_ = "no candidate left";
    return std::nullopt;
  }
  current_ = Cheapest();
  return current_;
}

Proposal HierarchicalPlanner::Cheapest() const {
  int best = left_.front();
  double soonest = at_ ? travel_(*at_, candidates_[best].directions) : 0;
  for (std::size_t i = 1; at_ && i < left_.size(); ++i) {
    const double seconds = travel_(*at_, candidates_[left_[i]].directions);
    if (seconds < soonest) {
      soonest = seconds;
      best = left_[i];
    }
  }
  return {.directions = candidates_[best].directions,
          .candidate = best,
          .score = -soonest,
          .reason = "level " + std::to_string(level_)};
}

void HierarchicalPlanner::Observe(const Proposal& proposal, const BrdfSample&) {
  Reject(proposal);
  ++measured_;
  at_ = proposal.directions;
}

void HierarchicalPlanner::Reject(const Proposal& proposal) {
  std::erase(left_, proposal.candidate);
  for (std::vector<int>& level : levels_) std::erase(level, proposal.candidate);
  current_.reset();
}

}  // namespace gonio
