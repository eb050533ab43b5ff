// SPDX-License-Identifier: Apache-2.0
// The maximum a posteriori DSBRDF of a set of samples, with its Laplace covariance.

#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "brdf/brdf.h"
#include "fitting/dsbrdf.h"
#include "fitting/estimate.h"
#include "fitting/prior.h"

namespace gonio {

struct FitOptions {
  double floor = 0.03;        // 1/sr, > 0: the floor of the generalised log (fitting/posterior.h)
  double huber = 1.0;         // > 0: residuals beyond this many sigma count linearly
  double model_error = 0.03;  // > 0: first guess of the spread of log f_r no DSBRDF explains; then
                              // estimated from the residuals
  double model_error_weight = 100;  // >= 0: how many residuals the guess is worth
  int max_iterations = 60;          // Gauss-Newton steps per minimisation, > 0
  double tolerance = 1e-5;  // > 0: relative fall of the cost below which a step was the last
  int start_samples = 500;  // poses the starts are compared on; the best two go on with all of them

  // Throws ConfigError naming the option.
  void Check() const;
};

// What happened; the numbers that did not work out are data.
struct FitSummary {
  bool converged = false;
  std::string reason;      // why the iteration ended
  int samples = 0;         // poses used
  int residuals = 0;       // scalar residuals used (pose x channel)
  int iterations = 0;      // Gauss-Newton steps of the winning start
  int starts = 0;          // starts that were iterated
  double cost = 0;         // negative log posterior up to a constant
  double model_error = 0;  // estimated standard deviation of log f_r beyond the samples' sigma
  double floor = 0;        // of the generalised log, 1/sr
};

// A fit is a reflectance that also knows how sure it is.
class DsbrdfFit final : public LobeModel {
 public:
  DsbrdfFit(Dsbrdf model, Eigen::MatrixXd covariance, FitSummary summary);

  using Brdf::Eval;
  std::optional<Rgb> Eval(const HalfDiff& angles) const override { return model_.Eval(angles); }
  std::string name() const override { return model_.name(); }
  int lobes() const override { return model_.lobes(); }
  std::vector<Lobe> LobesAt(double theta_d, int channel) const override {
    return model_.LobesAt(theta_d, channel);
  }

  // f_r with the standard deviation that parameter covariance and model error leave.
  Prediction Predict(const HalfDiff& angles) const;

  const Dsbrdf& model() const { return model_; }
  const Eigen::MatrixXd& covariance() const { return covariance_; }
  const FitSummary& summary() const { return summary_; }

 private:
  Dsbrdf model_;
  Eigen::MatrixXd covariance_;
  FitSummary summary_;
};

// Fits. Throws ConfigError if no sample is usable (all sigma infinite). Deterministic.
DsbrdfFit FitDsbrdf(std::span<const BrdfSample> samples, const Prior& prior,
                    const FitOptions& options = {});

// The same from one start, e.g. the parameters before the newest sample came in: cheap, and as good
// as the start is near.
DsbrdfFit RefitDsbrdf(std::span<const BrdfSample> samples, const Prior& prior,
                      const FitOptions& options, const Eigen::VectorXd& start, double model_error);

// FIT.yaml (docs/data-format.md), written atomically; reading throws ConfigError. Version 1 held
// only this kind of fit and is still read; fitting/table_fit.h reads and writes every kind.
inline constexpr int kFitFileVersion = 2;
void WriteFit(const std::filesystem::path& path, const DsbrdfFit& fit);
DsbrdfFit ReadFit(const std::filesystem::path& path);

}  // namespace gonio
