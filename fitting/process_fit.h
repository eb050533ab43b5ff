// SPDX-License-Identifier: Apache-2.0
// The reflectance a process makes of samples, anywhere, with its uncertainty.

#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "fitting/estimate.h"
#include "fitting/prior.h"
#include "fitting/process_posterior.h"

namespace gonio {

class ProcessFit final : public Estimate {
 public:
  ProcessFit(std::shared_ptr<const ProcessModel> model, const ProcessPosterior& posterior,
             const ProcessOptions& options);

  using Brdf::Eval;
  // Empty below the horizon.
  std::optional<Rgb> Eval(const HalfDiff& angles) const override;
  std::string name() const override { return "process"; }
  Prediction Predict(const HalfDiff& angles) const override;
  // Of a Gaussian z given that f_r >= 0: in the dark it begins at 0.
  Interval PredictInterval(const HalfDiff& angles, double probability) const override;

  // Standard deviation of each channel's z (fitting/process_model.h), model error included.
  Rgb SpreadAt(const HalfDiff& angles) const;

 private:
  Eigen::Vector3d MeanAt(const HalfDiff& angles) const;  // of z

  std::shared_ptr<const ProcessModel> model_;
  Eigen::MatrixXd field_;
  std::vector<ProcessPosterior::Knowledge> groups_;
  double model_error_;
};

// The reading of a sample.
ProcessReading ToReading(const ProcessModel& model, const BrdfSample& sample);

// x with P(|N(0, 1)| < x) = probability, 0 < probability < 1.
double CentralQuantile(double probability);

// The narrowest bounds that hold so much, 0 < probability < 1, of a Gaussian that is known to be
// `least` or more: symmetric about the mean, or from `least` on where the mean is near or below it.
struct Bounds {
  double low = 0;
  double high = 0;
};
Bounds NarrowestBounds(double mean, double sd, double least, double probability);

// How much wider than a Gaussian's an interval of this probability has to be: interpolated.
double WideningAt(const std::vector<Calibration>& calibration, double probability);

// Throws ConfigError if no sample is usable (all sigma infinite) or the prior has no process.
// Deterministic.
std::unique_ptr<ProcessFit> FitProcess(std::span<const BrdfSample> samples, const Prior& prior,
                                       const ProcessOptions& options = {});

}  // namespace gonio
