// SPDX-License-Identifier: Apache-2.0
#include "planner/sequence_planner.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <random>
#include <set>

#include "core/check.h"
#include "core/units.h"

namespace gonio {
namespace {

// The rows x columns raster of at most max_poses cells, as square as possible, then as full as
// possible.
void SquarestRaster(int max_poses, int* rows, int* columns) {
  *rows = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(max_poses))));
  *columns = std::max(1, max_poses / *rows);
}

// Turns every second row of a row-by-row order around, which saves the way back.
void TurnEverySecondRow(const std::vector<Candidate>& candidates, std::vector<int>* order) {
  bool backwards = false;
  for (auto row = order->begin(); row != order->end();) {
    const auto next = std::find_if(
        row, order->end(), [&](int i) { return candidates[i].row != candidates[*row].row; });
    if (backwards) std::reverse(row, next);
    backwards = !backwards;
    row = next;
  }
}

std::vector<int> CoarseRaster(const std::vector<Candidate>& candidates,
                              const CandidateOptions& raster, int max_poses) {
  int rows = 0;
  int columns = 0;
  SquarestRaster(max_poses, &rows, &columns);
  std::vector<int> order;
  std::set<int> taken;
  for (int row = 0; row < rows; ++row) {
    const double u = (row + 0.5) / rows;
    const double theta_h = (raster.merl_spacing ? u * u : u) * kPi / 2;
    for (int column = 0; column < columns; ++column) {
      const double theta_d = (column + 0.5) / columns * kPi / 2;
      const int nearest = NearestCandidate(candidates, theta_h, theta_d);
      if (nearest >= 0 && taken.insert(nearest).second) order.push_back(nearest);
    }
  }
  return order;
}

}  // namespace

SequencePlanner::SequencePlanner(std::vector<Candidate> candidates, std::vector<int> order,
                                 std::string label)
    : candidates_(std::move(candidates)),
      order_(std::move(order)),
      spent_(candidates_.size(), false),
      label_(std::move(label)) {}

std::optional<Proposal> SequencePlanner::Next() {
  while (next_ < order_.size() && spent_[order_[next_]]) ++next_;
  if (next_ >= order_.size()) return std::nullopt;
  const int candidate = order_[next_];
  return Proposal{.directions = candidates_[candidate].directions,
                  .candidate = candidate,
                  .score = 0,
                  .reason = label_};
}

void SequencePlanner::Observe(const Proposal& proposal, const BrdfSample&) { Reject(proposal); }

void SequencePlanner::Reject(const Proposal& proposal) {
  GONIO_CHECK(proposal.candidate >= 0 && proposal.candidate < std::ssize(candidates_),
              "answers name a candidate of the raster");
  spent_[proposal.candidate] = true;
}

std::vector<int> RasterOrder(const std::vector<Candidate>& candidates,
                             const CandidateOptions& raster, const RasterOptions& options) {
  GONIO_CHECK(options.every_theta_h > 0 && options.every_theta_d > 0, "strides are positive");
  std::vector<int> order;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (candidates[i].row % options.every_theta_h == 0 &&
        candidates[i].column % options.every_theta_d == 0) {
      order.push_back(static_cast<int>(i));
    }
  }
  if (options.max_poses > 0 && static_cast<int>(order.size()) > options.max_poses) {
    order = CoarseRaster(candidates, raster, options.max_poses);
  }
  TurnEverySecondRow(candidates, &order);
  return order;
}

std::vector<int> RandomOrder(std::size_t candidates, int count, std::uint64_t seed) {
  std::vector<int> order(candidates);
  std::iota(order.begin(), order.end(), 0);
  std::mt19937_64 generator(seed);
  // Fisher-Yates by hand: std::shuffle may differ between standard libraries, sessions must not.
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[generator() % i]);
  if (count > 0 && static_cast<std::size_t>(count) < order.size()) order.resize(count);
  return order;
}

}  // namespace gonio
