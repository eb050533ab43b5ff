// SPDX-License-Identifier: Apache-2.0
// The adaptive planner: measure where the remaining uncertainty matters most per second.

#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fitting/process_fit.h"
#include "planner/planner.h"
#include "planner/process_gain.h"

namespace gonio {

struct ProcessPlannerOptions {
  int max_poses = 100;      // > 0
  double target_error = 0;  // stop once PredictedError() is at most this; 0: no target
  double min_gain = 1e-4;   // >= 0: stop once no pose would take away this share of the variance
  int max_batch = 8;        // > 0: poses chosen, and ordered by travel, between two fits
  ProcessGainOptions gain;
  std::shared_ptr<const ProcessPrior> prior;  // not null
  ProcessOptions process;
};

// Fits a process to all samples (fitting/process_fit.h) and proposes the candidates with the
// largest expected gain (planner/process_gain.h), less what the seconds of travel, settling and
// exposure are worth; never one that was measured before. Without costs all poses take the same.
//
// Early poses are chosen one by one. Then batches grow to max_batch, since one more reading changes
// little, and a batch is visited in the order that is quickest. Where noise is what is left, a pose
// is exposed more than once.
//
// Nothing is random. Fitting happens in Next(): a few tens of milliseconds per batch.
class ProcessPlanner final : public Planner {
 public:
  // Preconditions: candidates is not empty, options.prior is not null.
  ProcessPlanner(std::vector<Candidate> candidates, ProcessPlannerOptions options,
                 SessionCosts costs = {});

  std::optional<Proposal> Next() override;
  void Observe(const Proposal& proposal, const BrdfSample& sample) override;
  void AlsoObserve(const BrdfSample& sample) override;
  void Reject(const Proposal& proposal) override;
  std::string reason() const override { return reason_; }
  int MaxPoses() const override { return options_.max_poses; }
  std::optional<double> PredictedError() const override { return predicted_error_; }
  std::optional<Rgb> Predict(const DirectionPair& pair) const override;

 private:
  std::optional<Proposal> Choose();
  Proposal Propose(const ProcessGain::Choice& choice, int frames) const;
  void Refit();
  std::string Enough() const;
  void ChooseBatch();
  class SecondsTo;
  double WorthOfSecond(const std::vector<bool>& taken, SecondsTo* seconds) const;
  ProcessGain::Choice ChooseBeside(const std::vector<bool>& taken, double second,
                                   SecondsTo* seconds) const;
  int FramesAt(const ProcessGain::Choice& choice, double second) const;
  std::size_t IndexOf(const Candidate& candidate) const;
  void OrderBatch();
  int BatchSize() const;
  double TravelFrom(const DirectionPair& from, const DirectionPair& to) const;
  double PoseTime(const DirectionPair& pair) const;

  ProcessPlannerOptions options_;
  SessionCosts costs_;
  ProcessGain gain_;
  std::vector<bool> spent_;  // measured or rejected
  int measured_ = 0;
  std::vector<BrdfSample> samples_;
  std::optional<DirectionPair> position_;  // where the last pose left the arms
  std::shared_ptr<const ProcessModel> model_;
  std::optional<ProcessPosterior> posterior_;
  std::vector<ProcessReading> readings_;  // of samples_, in model_
  std::size_t fitted_ = 0;                // samples the posterior knows
  std::deque<Proposal> batch_;
  std::optional<double> predicted_error_;
  std::optional<Proposal> current_;
  std::string reason_;
};

}  // namespace gonio
