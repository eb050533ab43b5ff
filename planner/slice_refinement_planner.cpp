// SPDX-License-Identifier: Apache-2.0
#include "planner/slice_refinement_planner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/check.h"
#include "core/units.h"
#include "planner/information_gain.h"

namespace gonio {
namespace {

// A theta_d slice's step counts half: reflectance changes more slowly along theta_d.
constexpr double kThetaDStretch = 0.5;
// A peak, where no slice knows its curvature yet.
constexpr double kUnknownCurvature = 20;
// Beyond the outermost reading y is extrapolated, which errs this much more.
constexpr double kBeyond = 2;

struct OpeningPose {
  double theta_h_deg, theta_d_deg;
};
// Ordered so that even the first few tell something of peak, base and Fresnel rise.
constexpr OpeningPose kOpening[] = {{0.1, 40}, {32, 40}, {8, 40}, {0.1, 75}, {0.1, 5}, {32, 5},
                                    {8, 5},    {3, 40},  {8, 75}, {75, 5},   {1, 20},  {32, 60}};

}  // namespace

SliceRefinementPlanner::SliceRefinementPlanner(std::vector<Candidate> candidates,
                                               const SliceRefinementOptions& options)
    : candidates_(std::move(candidates)),
      options_(options),
      max_poses_(static_cast<int>(candidates_.size())),
      spent_(candidates_.size(), false),
      readings_(candidates_.size()) {
  GONIO_CHECK(!candidates_.empty(), "a planner needs candidates");
  if (options.max_poses > 0) max_poses_ = std::min(max_poses_, options.max_poses);
  for (const OpeningPose& pose : kOpening) {
    const int nearest =
        NearestCandidate(candidates_, RadFromDeg(pose.theta_h_deg), RadFromDeg(pose.theta_d_deg));
    if (std::find(opening_.begin(), opening_.end(), nearest) == opening_.end()) {
      opening_.push_back(nearest);
    }
  }
  for (std::size_t i = 0; i < opening_.size(); ++i) {
    const Candidate& candidate = candidates_[opening_[i]];
    StartSlice(kAlongThetaH, candidate.column);
    if (i < 3) StartSlice(kAlongThetaD, candidate.row);
  }
}

double SliceRefinementPlanner::Position(Kind kind, int candidate) const {
  const HalfDiff& angles = candidates_[candidate].angles;
  return kind == kAlongThetaH ? std::sqrt(angles.theta_h / (kPi / 2))
                              : kThetaDStretch * angles.theta_d / (kPi / 2);
}

void SliceRefinementPlanner::StartSlice(Kind kind, int index) {
  Slice& slice = slices_[kind][index];
  if (!slice.members.empty()) return;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {  // raster order is along both kinds
    const int across = kind == kAlongThetaH ? candidates_[i].column : candidates_[i].row;
    if (across == index) slice.members.push_back(static_cast<int>(i));
  }
}

// False if every candidate is spent.
bool SliceRefinementPlanner::StartInWidestGap() {
  int widest = -1;
  int gap = -1;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    if (spent_[i]) continue;
    int nearest = static_cast<int>(candidates_.size());
    for (const auto& [column, slice] : slices_[kAlongThetaH]) {
      nearest = std::min(nearest, std::abs(column - candidates_[i].column));
    }
    if (nearest > gap) {
      gap = nearest;
      widest = candidates_[i].column;
    }
  }
  if (widest >= 0) StartSlice(kAlongThetaH, widest);
  return widest >= 0;
}

std::optional<Proposal> SliceRefinementPlanner::Next() {
  if (current_ || !reason_.empty()) return current_;
  if (measured_ >= max_poses_) {
    reason_ = "pose budget reached";
    return std::nullopt;
  }
  chosen_ = {};
  for (const int candidate : opening_) {
    if (spent_[candidate]) continue;
    current_ = Propose({.candidate = candidate, .score = 0}, "opening");
    return current_;
  }
  chosen_ = Choose();
  if (chosen_.candidate < 0 && StartInWidestGap()) chosen_ = Choose();
  if (chosen_.candidate < 0) {
    reason_ = "no candidate left";
    return std::nullopt;
  }
  current_ = Propose(chosen_, chosen_.kind == kAlongThetaH ? "theta_h slice" : "theta_d slice");
  return current_;
}

SliceRefinementPlanner::Choice SliceRefinementPlanner::Choose() const {
  Choice best;
  for (const Kind kind : {kAlongThetaH, kAlongThetaD}) {
    std::map<int, std::vector<Knot>> knots;
    for (const auto& [index, slice] : slices_[kind]) knots[index] = Knots(kind, slice);
    for (const auto& [index, slice] : slices_[kind]) ConsiderSlice(kind, index, knots, &best);
  }
  return best;
}

std::vector<SliceRefinementPlanner::Knot> SliceRefinementPlanner::Knots(Kind kind,
                                                                        const Slice& slice) const {
  std::vector<Knot> knots;
  for (std::size_t m = 0; m < slice.members.size(); ++m) {
    const auto& reading = readings_[slice.members[m]];
    if (!reading) continue;
    knots.push_back({.member = m,
                     .position = Position(kind, slice.members[m]),
                     .noise = reading->noise.mean()});
  }
  const auto y = [&](const Knot& knot) { return readings_[slice.members[knot.member]]->y; };
  for (std::size_t j = 1; j + 1 < knots.size(); ++j) {
    const double before = knots[j].position - knots[j - 1].position;
    const double after = knots[j + 1].position - knots[j].position;
    const Rgb bend =
        (y(knots[j + 1]) - y(knots[j])) / after - (y(knots[j]) - y(knots[j - 1])) / before;
    knots[j].curvature = 2 * bend.abs().mean() / (before + after);
  }
  return knots;
}

// Half of what lies between a slice and its neighbours of the same kind, on the unit square.
double SliceRefinementPlanner::Cover(Kind kind, int index) const {
  const Kind across = kind == kAlongThetaH ? kAlongThetaD : kAlongThetaH;
  const Slices& slices = slices_[kind];
  const auto here = slices.find(index);
  const auto place = [&](Slices::const_iterator slice) {
    return Position(across, slice->second.members.front());
  };
  const double low = here == slices.begin() ? 0 : (place(here) + place(std::prev(here))) / 2;
  const double end = across == kAlongThetaD ? kThetaDStretch : 1;
  const double high =
      std::next(here) == slices.end() ? end : (place(here) + place(std::next(here))) / 2;
  return high - low;
}

int SliceRefinementPlanner::NearestUnspent(Kind kind, const Slice& slice, std::size_t first,
                                           std::size_t last, double position) const {
  int best = -1;
  double nearest = 0;
  for (std::size_t m = first; m < last; ++m) {
    const int candidate = slice.members[m];
    const double distance = std::abs(Position(kind, candidate) - position);
    if (spent_[candidate] || (best >= 0 && distance >= nearest)) continue;
    best = candidate;
    nearest = distance;
  }
  return best;
}

// The curvature that the nearest slice of the same kind knows nearest to a position.
double SliceRefinementPlanner::Lent(const std::map<int, std::vector<Knot>>& knots, int index,
                                    double position) const {
  double curvature = kUnknownCurvature;
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [other, others] : knots) {
    for (const Knot& knot : others) {
      // Slices count first: they are whole raster steps apart, positions at most 1.
      const double away = std::abs(other - index) + std::abs(knot.position - position);
      if (other == index || knot.curvature < 0 || away >= nearest) continue;
      nearest = away;
      curvature = knot.curvature;
    }
  }
  return options_.borrowed * curvature;
}

void SliceRefinementPlanner::ConsiderSlice(Kind kind, int index,
                                           const std::map<int, std::vector<Knot>>& knots,
                                           Choice* best) const {
  const std::vector<int>& members = slices_[kind].at(index).members;
  const std::vector<Knot>& own = knots.at(index);
  const double cover = Cover(kind, index);
  // Stand in for a reading before the first member and one after the last.
  const Knot begin{.member = static_cast<std::size_t>(-1),
                   .position = Position(kind, members.front())};
  const Knot end{.member = members.size(), .position = Position(kind, members.back())};
  for (std::size_t j = 0; j <= own.size(); ++j) {  // the interval before knot j; the last one after
    const Knot& left = j > 0 ? own[j - 1] : begin;
    const Knot& right = j < own.size() ? own[j] : end;
    const double middle = (left.position + right.position) / 2;
    const int candidate =
        NearestUnspent(kind, slices_[kind].at(index), left.member + 1, right.member, middle);
    if (candidate < 0) continue;
    double curvature = std::max(left.curvature, right.curvature);
    if (curvature < 0) curvature = Lent(knots, index, middle);
    const bool inside = j > 0 && j < own.size();
    const double step = (right.position - left.position) * (inside ? 1 : kBeyond);
    const double noise = std::max(left.noise, right.noise);
    const double error = std::max(0.0, step * step * curvature / 8 - noise / 2);
    const double score = step * cover * (error + options_.curiosity);
    if (score > best->score) *best = {.candidate = candidate, .kind = kind, .score = score};
  }
}

Proposal SliceRefinementPlanner::Propose(const Choice& choice, const std::string& why) const {
  return {.directions = candidates_[choice.candidate].directions,
          .candidate = choice.candidate,
          .score = choice.score,
          .reason = why};
}

void SliceRefinementPlanner::Observe(const Proposal& proposal, const BrdfSample& sample) {
  Reject(proposal);
  ++measured_;
  Reading reading;
  for (int c = 0; c < kChannels; ++c) {
    if (!std::isfinite(sample.sigma[c]) || !std::isfinite(sample.f_r[c])) return;
    const double above = std::max(sample.f_r[c], 0.0) + options_.floor;
    reading.y[c] = std::log(above);
    reading.noise[c] = sample.sigma[c] / above;
  }
  readings_[proposal.candidate] = reading;
  if (chosen_.candidate == proposal.candidate && chosen_.kind == kAlongThetaD)
    StartSlice(kAlongThetaH, candidates_[proposal.candidate].column);
}

void SliceRefinementPlanner::Reject(const Proposal& proposal) {
  spent_[proposal.candidate] = true;
  current_.reset();
}

}  // namespace gonio
