// SPDX-License-Identifier: Apache-2.0
#include "planner/information_planner.h"

#include <algorithm>

#include "core/check.h"
#include "core/units.h"

namespace gonio {
namespace {

struct OpeningPose {
  double theta_h_deg;
  double theta_d_deg;
};

// The peak at its top and flanks, the shoulder, the diffuse level, and the Fresnel rise.
constexpr OpeningPose kOpening[] = {{0.05, 5}, {1, 12},  {4, 25},  {12, 40},
                                    {30, 10},  {55, 25}, {25, 55}, {2, 70}};

// All starts are tried again when the samples have grown by this factor.
constexpr double kAllStartsGrowth = 1.5;

}  // namespace

InformationPlanner::InformationPlanner(std::vector<Candidate> candidates,
                                       InformationOptions options)
    : options_(std::move(options)),
      gain_(std::move(candidates), options_.gain),
      spent_(gain_.candidates().size(), false) {
  GONIO_CHECK(!gain_.candidates().empty(), "a planner needs candidates");
  for (const OpeningPose& pose : kOpening) {
    const int nearest = NearestCandidate(gain_.candidates(), RadFromDeg(pose.theta_h_deg),
                                         RadFromDeg(pose.theta_d_deg));
    if (std::find(opening_.begin(), opening_.end(), nearest) == opening_.end()) {
      opening_.push_back(nearest);
    }
  }
}

std::optional<Proposal> InformationPlanner::Next() {
  if (!current_ && reason_.empty()) current_ = Choose();
  return current_;
}

std::optional<Proposal> InformationPlanner::Choose() {
  const bool budget_left = poses_ < options_.max_poses;
  for (const int candidate : opening_) {
    if (budget_left && !spent_[candidate]) return Propose(candidate, 0, "opening");
  }
  if (!samples_.empty()) Refit();
  if (!fit_) {  // every opening pose was rejected: go through the rest until one works
    const auto left = std::find(spent_.begin(), spent_.end(), false);
    if (budget_left && left != spent_.end()) {
      return Propose(static_cast<int>(left - spent_.begin()), 0, "opening");
    }
    reason_ = "no pose could be measured";
    return std::nullopt;
  }
  GainScores scores = gain_.Evaluate(*fit_, measured_);
  predicted_error_ = scores.predicted_error;
  if (!budget_left) {
    reason_ = "pose budget reached";
    return std::nullopt;
  }
  if (options_.target_error > 0 && scores.predicted_error <= options_.target_error) {
    reason_ = "target error reached";
    return std::nullopt;
  }
  for (std::size_t i = 0; i < spent_.size(); ++i) {
    if (spent_[i]) scores.gain[static_cast<Eigen::Index>(i)] = -1;
  }
  Eigen::Index best = 0;
  const double gain = scores.gain.maxCoeff(&best);
  if (gain < options_.min_gain) {
    reason_ = gain < 0 ? "no candidate left" : "no more gain";
    return std::nullopt;
  }
  return Propose(static_cast<int>(best), gain, "information");
}

Proposal InformationPlanner::Propose(int candidate, double score, std::string why) const {
  return {.directions = gain_.candidates()[candidate].directions,
          .candidate = candidate,
          .score = score,
          .reason = std::move(why)};
}

void InformationPlanner::Refit() {
  if (fit_ && fit_->summary().samples == static_cast<int>(samples_.size())) return;
  if (!fit_ || samples_.size() >= all_starts_at_) {
    fit_ = FitDsbrdf(samples_, options_.prior, options_.fit);
    all_starts_at_ = static_cast<std::size_t>(
        std::max(12.0, kAllStartsGrowth * static_cast<double>(samples_.size())));
  } else {
    fit_ = RefitDsbrdf(samples_, options_.prior, options_.fit, fit_->model().parameters(),
                       fit_->summary().model_error);
  }
}

void InformationPlanner::Observe(const Proposal& proposal, const BrdfSample& sample) {
  Reject(proposal);
  ++poses_;
  measured_.push_back(proposal.candidate);
  Keep(sample);
}

void InformationPlanner::AlsoObserve(const BrdfSample& sample) {
  const HalfDiff at = ToHalfDiff(sample.directions);
  measured_.push_back(NearestCandidate(gain_.candidates(), at.theta_h, at.theta_d));
  Keep(sample);
}

void InformationPlanner::Keep(const BrdfSample& sample) {
  if (sample.sigma.isFinite().any()) samples_.push_back(sample);
}

void InformationPlanner::Reject(const Proposal& proposal) {
  spent_[proposal.candidate] = true;
  current_.reset();
}

std::optional<double> InformationPlanner::PredictedError() const { return predicted_error_; }

std::optional<Rgb> InformationPlanner::Predict(const DirectionPair& pair) const {
  if (!fit_) return std::nullopt;
  return fit_->Eval(pair);
}

}  // namespace gonio
