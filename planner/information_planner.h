// SPDX-License-Identifier: Apache-2.0
// The adaptive planner: measure where the fit's remaining uncertainty matters most.

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fitting/fit.h"
#include "planner/information_gain.h"
#include "planner/planner.h"

namespace gonio {

struct InformationOptions {
  int max_poses = 100;      // > 0
  double target_error = 0;  // stop once PredictedError() is at most this; 0: no target
  double min_gain = 1e-4;   // >= 0: stop once no pose would take away this share of the variance
  GainOptions gain;
  Prior prior;
  FitOptions fit;
};

// Opens with a few fixed poses that tell the kinds of materials apart (peak, shoulder, diffuse
// level, grazing: a linearised prior misjudges sharp peaks, so it does not choose them), then
// refits after every sample and proposes the candidate with the largest expected gain
// (planner/information_gain.h), never one that was measured before.
//
// Most refits start from the last parameters; at geometrically spaced counts all starts are tried
// again, so that an early misunderstanding does not last. Nothing is random.
//
// Fitting happens in Next(): a few milliseconds per call, tens where all starts are tried.
class InformationPlanner final : public Planner {
 public:
  // Precondition: candidates is not empty.
  InformationPlanner(std::vector<Candidate> candidates, InformationOptions options);

  std::optional<Proposal> Next() override;
  void Observe(const Proposal& proposal, const BrdfSample& sample) override;
  void AlsoObserve(const BrdfSample& sample) override;
  void Reject(const Proposal& proposal) override;
  std::string reason() const override { return reason_; }
  int MaxPoses() const override { return options_.max_poses; }
  std::optional<double> PredictedError() const override;
  std::optional<Rgb> Predict(const DirectionPair& pair) const override;

  // The fit after the last Next(); null during the opening.
  const DsbrdfFit* fit() const { return fit_ ? &*fit_ : nullptr; }

 private:
  std::optional<Proposal> Choose();
  Proposal Propose(int candidate, double score, std::string why) const;
  void Refit();
  void Keep(const BrdfSample& sample);

  InformationOptions options_;
  InformationGain gain_;
  std::vector<int> opening_;
  std::vector<bool> spent_;    // measured or rejected
  int poses_ = 0;              // measured
  std::vector<int> measured_;  // those nearest to the samples
  std::vector<BrdfSample> samples_;
  std::optional<DsbrdfFit> fit_;
  std::size_t all_starts_at_ = 0;  // number of samples at which every start is tried again
  std::optional<double> predicted_error_;
  std::optional<Proposal> current_;
  std::string reason_;
};

}  // namespace gonio
