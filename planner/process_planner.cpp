// SPDX-License-Identifier: Apache-2.0
#include "planner/process_planner.h"

#include <algorithm>
#include <utility>

#include "core/check.h"

namespace gonio {
namespace {

// So many poses are chosen one by one; then a batch is a share of what was measured.
constexpr int kSingle = 12;
constexpr double kBatchShare = 0.1;
// What a second is worth, out of the most that one could bring now. Later ones will bring less, and
// it is those that a slow pose takes away (docs/planning.md).
constexpr double kHaste = 0.5;
// f_r [1/sr] before anything is known.
const Rgb kUnknown = Rgb::Constant(0.1);

}  // namespace

// Seconds until a candidate would be measured, coming from the nearest of the poses before it.
// Remembered: every pose of a batch asks for those of the same candidates.
class ProcessPlanner::SecondsTo {
 public:
  explicit SecondsTo(const ProcessPlanner& planner)
      : planner_(planner), known_(planner.gain_.candidates().size()) {}

  void AddStart(const DirectionPair& pair) { starts_.push_back(pair); }

  double Of(std::size_t candidate) {
    Known& known = known_[candidate];
    const DirectionPair& pair = planner_.gain_.candidates()[candidate].directions;
    if (known.pose == 0) known.pose = planner_.PoseTime(pair);
    for (; known.starts < starts_.size(); ++known.starts) {
      const double travel = planner_.TravelFrom(starts_[known.starts], pair);
      known.travel = known.starts == 0 ? travel : std::min(known.travel, travel);
    }
    return known.pose + known.travel;
  }

 private:
  struct Known {
    double pose = 0;    // 0: not asked yet
    double travel = 0;  // from the nearest of the first `starts`
    std::size_t starts = 0;
  };
  const ProcessPlanner& planner_;
  std::vector<DirectionPair> starts_;
  std::vector<Known> known_;
};

ProcessPlanner::ProcessPlanner(std::vector<Candidate> candidates, ProcessPlannerOptions options,
                               SessionCosts costs)
    : options_(std::move(options)),
      costs_(std::move(costs)),
      gain_(std::move(candidates), options_.gain),
      spent_(gain_.candidates().size(), false) {
  GONIO_CHECK(!gain_.candidates().empty(), "a planner needs candidates");
  GONIO_CHECK(options_.prior != nullptr, "a process needs a prior");
  model_ = std::make_shared<const ProcessModel>(*options_.prior);
}

std::optional<Proposal> ProcessPlanner::Next() {
  if (!current_ && reason_.empty()) current_ = Choose();
  return current_;
}

std::optional<Proposal> ProcessPlanner::Choose() {
  if (batch_.empty()) {
    Refit();
    reason_ = measured_ < options_.max_poses ? Enough() : "pose budget reached";
    if (reason_.empty()) ChooseBatch();
    if (!reason_.empty()) return std::nullopt;
  }
  const Proposal next = batch_.front();
  batch_.pop_front();
  return next;
}

std::string ProcessPlanner::Enough() const {
  if (samples_.empty() || !(options_.target_error > 0)) return {};
  if (*predicted_error_ <= options_.target_error) return "target error reached";
  if (gain_.floor_error() >= options_.target_error &&
      gain_.predicted_error() < 1.2 * gain_.floor_error()) {
    return "target error is below what the model can reach; nothing more to gain";
  }
  return {};
}

void ProcessPlanner::Refit() {
  if (posterior_ && fitted_ == samples_.size()) return;
  for (std::size_t n = readings_.size(); n < samples_.size(); ++n) {
    readings_.push_back(ToReading(*model_, samples_[n]));
  }
  posterior_.emplace(*model_, readings_, options_.process);
  fitted_ = samples_.size();
  gain_.Learn(model_, *posterior_, options_.process);
  if (!samples_.empty()) predicted_error_ = gain_.predicted_error();
}

int ProcessPlanner::BatchSize() const {
  const int size = measured_ < kSingle ? 1 : static_cast<int>(1 + kBatchShare * measured_);
  return std::min({size, options_.max_batch, options_.max_poses - measured_});
}

std::size_t ProcessPlanner::IndexOf(const Candidate& candidate) const {
  return static_cast<std::size_t>(&candidate - gain_.candidates().data());
}

double ProcessPlanner::TravelFrom(const DirectionPair& from, const DirectionPair& to) const {
  return costs_.travel ? costs_.travel(from, to) : 0;
}

double ProcessPlanner::PoseTime(const DirectionPair& pair) const {
  if (!costs_.pose) return 1;
  return costs_.pose(pair, Predict(pair).value_or(kUnknown));
}

// What a second is worth: a share of the highest gain per second there is now.
double ProcessPlanner::WorthOfSecond(const std::vector<bool>& taken, SecondsTo* seconds) const {
  if (!costs_.travel && !costs_.pose) return 0;
  const auto rate = [&](const Candidate& candidate, double gain) {
    return gain / seconds->Of(IndexOf(candidate));
  };
  return kHaste * gain_.Best(taken, rate).score;
}

// The next of a batch that has these: the most gain for its seconds, or the most where that would
// end the session although there is more to gain farther away.
ProcessGain::Choice ProcessPlanner::ChooseBeside(const std::vector<bool>& taken, double second,
                                                 SecondsTo* seconds) const {
  const auto net = [&](const Candidate& candidate, double gain) {
    return gain - second * seconds->Of(IndexOf(candidate));
  };
  const ProcessGain::Choice choice = gain_.Best(taken, net);
  if (choice.candidate < 0 || choice.gain >= options_.min_gain) return choice;
  return gain_.Best(taken, [](const Candidate&, double gain) { return gain; });
}

// How often to expose there. More than once pays where noise is what is left and the way there was
// long.
int ProcessPlanner::FramesAt(const ProcessGain::Choice& choice, double second) const {
  if (!costs_.frame) return 1;
  const DirectionPair& pair = gain_.candidates()[choice.candidate].directions;
  const double more = costs_.frame(pair, Predict(pair).value_or(kUnknown));
  int best = 1;
  double best_net = choice.gain;
  for (int frames = 2; frames <= costs_.max_frames; frames *= 2) {
    const double net = gain_.GainOf(choice.candidate, frames) - second * (frames - 1) * more;
    if (net <= best_net) break;
    best = frames;
    best_net = net;
  }
  return best;
}

void ProcessPlanner::ChooseBatch() {
  const int size = BatchSize();
  std::vector<bool> taken = spent_;
  SecondsTo seconds(*this);
  if (position_) seconds.AddStart(*position_);
  while (static_cast<int>(batch_.size()) < size) {
    const double second = WorthOfSecond(taken, &seconds);
    const ProcessGain::Choice choice = ChooseBeside(taken, second, &seconds);
    if (choice.candidate < 0 || choice.gain < options_.min_gain) {
      if (batch_.empty()) reason_ = choice.candidate < 0 ? "no candidate left" : "no more gain";
      break;
    }
    const int frames = FramesAt(choice, second);
    batch_.push_back(Propose(choice, frames));
    taken[choice.candidate] = true;
    seconds.AddStart(batch_.back().directions);
    gain_.Suppose(choice.candidate, frames);
  }
  OrderBatch();
}

// The quickest round through the batch from where the arms stand: nearest first, then 2-opt.
void ProcessPlanner::OrderBatch() {
  if (!costs_.travel || batch_.size() < 2) return;
  const auto nearest = [&](const DirectionPair& from, std::size_t begin) {
    std::size_t best = begin;
    for (std::size_t i = begin + 1; i < batch_.size(); ++i) {
      if (TravelFrom(from, batch_[i].directions) < TravelFrom(from, batch_[best].directions)) {
        best = i;
      }
    }
    return best;
  };
  for (std::size_t i = 0; i < batch_.size(); ++i) {
    if (i == 0 && !position_) continue;
    std::swap(batch_[i], batch_[nearest(i == 0 ? *position_ : batch_[i - 1].directions, i)]);
  }
  const auto leg = [&](std::ptrdiff_t a, std::size_t b) {
    if (b >= batch_.size() || (a < 0 && !position_)) return 0.0;
    return TravelFrom(a < 0 ? *position_ : batch_[a].directions, batch_[b].directions);
  };
  for (bool better = true; better;) {
    better = false;
    for (std::size_t i = 0; i + 1 < batch_.size(); ++i) {
      for (std::size_t j = i + 1; j < batch_.size(); ++j) {
        const auto before = static_cast<std::ptrdiff_t>(i) - 1;
        const double now = leg(before, i) + leg(static_cast<std::ptrdiff_t>(j), j + 1);
        const double turned = leg(before, j) + leg(static_cast<std::ptrdiff_t>(i), j + 1);
        if (turned < now - 1e-9) {
          std::reverse(batch_.begin() + static_cast<std::ptrdiff_t>(i),
                       batch_.begin() + static_cast<std::ptrdiff_t>(j) + 1);
          better = true;
        }
      }
    }
  }
}

Proposal ProcessPlanner::Propose(const ProcessGain::Choice& choice, int frames) const {
  return {.directions = gain_.candidates()[choice.candidate].directions,
          .candidate = choice.candidate,
          .score = choice.score,
          .reason = "information",
          .frames = frames};
}

void ProcessPlanner::Observe(const Proposal& proposal, const BrdfSample& sample) {
  Reject(proposal);
  ++measured_;
  position_ = proposal.directions;
  AlsoObserve(sample);
}

void ProcessPlanner::AlsoObserve(const BrdfSample& sample) {
  if (sample.sigma.isFinite().any()) samples_.push_back(sample);
}

void ProcessPlanner::Reject(const Proposal& proposal) {
  // Of a pose that was not asked for: the last proposal is still the next, unless it was that one.
  std::erase_if(batch_, [&](const Proposal& p) { return p.candidate == proposal.candidate; });
  if (current_ && current_->candidate != proposal.candidate) batch_.push_front(*current_);
  spent_[proposal.candidate] = true;
  current_.reset();
}

std::optional<Rgb> ProcessPlanner::Predict(const DirectionPair& pair) const {
  if (!posterior_) return std::nullopt;
  return model_->ReflectanceOf(posterior_->Mean(model_->At(ToHalfDiff(pair))));
}

}  // namespace gonio
