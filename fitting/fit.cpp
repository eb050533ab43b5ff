// SPDX-License-Identifier: Apache-2.0
#include "fitting/fit.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/error.h"
#include "fitting/generalised_log.h"
#include "fitting/levenberg_marquardt.h"
#include "fitting/posterior.h"
#include "fitting/slice.h"
#include "fitting/starts.h"

namespace gonio {
namespace {

using MapMinimum = Minimum<Eigen::Dynamic>;

Eigen::MatrixXd Inverse(const Eigen::MatrixXd& hessian) {
  Eigen::MatrixXd inverse =
      hessian.llt().solve(Eigen::MatrixXd::Identity(hessian.rows(), hessian.cols()));
  // Symmetric to the last bit, as the file that holds its lower triangle is.
  inverse.triangularView<Eigen::StrictlyUpper>() = inverse.transpose();
  return inverse;
}

// Minimises, lets the residuals speak about the model error, and minimises again with it. Two
// rounds are enough: the estimate moves the minimum little.
MapMinimum MinimiseWithModelError(Posterior& posterior, const Eigen::VectorXd& start,
                                  const FitOptions& options) {
  MapMinimum minimum = Minimise(posterior, start, options.max_iterations, options.tolerance);
  int iterations = minimum.iterations;
  for (int round = 0; round < 2; ++round) {
    posterior.set_model_error(posterior.EstimateModelError(
        minimum.parameters, minimum.hessian, options.model_error, options.model_error_weight));
    minimum = Minimise(posterior, minimum.parameters, options.max_iterations, options.tolerance);
    iterations += minimum.iterations;
  }
  minimum.iterations = iterations;
  return minimum;
}

PosteriorOptions ToPosteriorOptions(const FitOptions& options) {
  return {.floor = options.floor, .huber = options.huber, .model_error = options.model_error};
}

// The samples of which at least one channel could be measured.
std::vector<BrdfSample> Usable(std::span<const BrdfSample> samples) {
  std::vector<BrdfSample> usable;
  std::copy_if(samples.begin(), samples.end(), std::back_inserter(usable),
               [](const BrdfSample& sample) { return sample.sigma.isFinite().any(); });
  return usable;
}

// Every stride-th sample, so that at most `count` remain.
std::vector<BrdfSample> Thin(std::span<const BrdfSample> samples, int count) {
  const std::size_t stride = (samples.size() + count - 1) / count;
  std::vector<BrdfSample> thin;
  for (std::size_t n = 0; n < samples.size(); n += stride) thin.push_back(samples[n]);
  return thin;
}

// Where each start leads, best first. Roughly is enough to tell the explanations apart.
std::vector<MapMinimum> BestMinima(const Posterior& posterior,
                                   const std::vector<Eigen::VectorXd>& starts,
                                   const FitOptions& options) {
  std::vector<MapMinimum> minima;
  minima.reserve(starts.size());
  for (const Eigen::VectorXd& start : starts) {
    minima.push_back(Minimise(posterior, start, options.max_iterations, 10 * options.tolerance));
  }
  std::stable_sort(minima.begin(), minima.end(),
                   [](const MapMinimum& a, const MapMinimum& b) { return a.cost < b.cost; });
  return minima;
}

DsbrdfFit ToFit(const Posterior& posterior, const MapMinimum& minimum, int samples, int starts) {
  FitSummary summary;
  summary.converged = minimum.converged;
  summary.reason = minimum.converged ? "cost no longer falls" : "iteration limit";
  summary.samples = samples;
  summary.residuals = posterior.residual_count();
  summary.iterations = minimum.iterations;
  summary.starts = starts;
  summary.cost = minimum.cost;
  summary.model_error = posterior.options().model_error;
  summary.floor = posterior.options().floor;
  return DsbrdfFit(Dsbrdf(posterior.prior().shape, minimum.parameters), Inverse(minimum.hessian),
                   summary);
}

void RequireResiduals(const Posterior& posterior) {
  if (posterior.residual_count() == 0) {
    throw ConfigError("nothing to fit: no sample has a channel with a finite sigma");
  }
}

}  // namespace

void FitOptions::Check() const {
  const auto require = [](bool holds, const char* name, const char* condition) {
    if (!holds) throw ConfigError(fmt::format("fit.{}: must be {}", name, condition));
  };
  require(floor > 0 && std::isfinite(floor), "floor", "> 0");
  require(huber > 0, "huber", "> 0");
  require(model_error > 0 && std::isfinite(model_error), "model_error", "> 0");
  require(model_error_weight >= 0, "model_error_weight", ">= 0");
  require(max_iterations > 0, "max_iterations", "> 0");
  require(tolerance > 0, "tolerance", "> 0");
  require(start_samples > 0, "start_samples", "> 0");
}

DsbrdfFit::DsbrdfFit(Dsbrdf model, Eigen::MatrixXd covariance, FitSummary summary)
    : model_(std::move(model)), covariance_(std::move(covariance)), summary_(std::move(summary)) {
  GONIO_CHECK(covariance_.rows() == model_.parameters().size() &&
                  covariance_.cols() == model_.parameters().size(),
              "covariance of every parameter");
}

Prediction DsbrdfFit::Predict(const HalfDiff& angles) const {
  const DsbrdfShape& shape = model_.shape();
  const Slice slice(shape, model_.parameters(), angles.theta_d);
  const SplineBasis& basis = slice.basis();
  const double log_cos = LogCos(angles.theta_h);
  Prediction prediction;
  Eigen::VectorXd gradient(2 * shape.lobes);
  Eigen::VectorXd row = Eigen::VectorXd::Zero(shape.per_channel());
  for (int c = 0; c < kChannels; ++c) {
    const double f = slice.EvalWithGradient(c, log_cos, gradient.data());
    row.setZero();
    for (int a = 0; a < gradient.size(); ++a) {
      for (int j = 0; j < 4; ++j) {
        row[a * shape.knots + basis.first + j] = gradient[a] * basis.weight[j];
      }
    }
    const int offset = shape.Index(c, 0, 0);
    const auto block = covariance_.block(offset, offset, row.size(), row.size());
    const double off_model = summary_.model_error / GeneralisedLogSlope(f, summary_.floor);
    prediction.f_r[c] = f;
    prediction.sigma[c] = std::sqrt(row.dot(block * row) + off_model * off_model);
  }
  return prediction;
}

DsbrdfFit FitDsbrdf(std::span<const BrdfSample> samples, const Prior& prior,
                    const FitOptions& options) {
  options.Check();
  const std::vector<BrdfSample> usable = Usable(samples);
  const std::vector<BrdfSample> few = Thin(usable, options.start_samples);
  Posterior posterior(few, prior, ToPosteriorOptions(options));
  RequireResiduals(posterior);
  const std::vector<Eigen::VectorXd> starts = FitStarts(few, prior);
  std::vector<MapMinimum> minima = BestMinima(posterior, starts, options);
  if (few.size() < usable.size()) {
    // What all samples say may differ from what a few said, so the runner-up gets its chance.
    posterior = Posterior(usable, prior, ToPosteriorOptions(options));
    minima = BestMinima(posterior, {minima[0].parameters, minima[1].parameters}, options);
  }
  const MapMinimum minimum = MinimiseWithModelError(posterior, minima[0].parameters, options);
  return ToFit(posterior, minimum, static_cast<int>(usable.size()),
               static_cast<int>(starts.size()));
}

DsbrdfFit RefitDsbrdf(std::span<const BrdfSample> samples, const Prior& prior,
                      const FitOptions& options, const Eigen::VectorXd& start, double model_error) {
  PosteriorOptions posterior_options = ToPosteriorOptions(options);
  posterior_options.model_error = model_error;
  Posterior posterior(samples, prior, posterior_options);
  RequireResiduals(posterior);
  const MapMinimum minimum = Minimise(posterior, start, options.max_iterations, options.tolerance);
  posterior.set_model_error(posterior.EstimateModelError(
      minimum.parameters, minimum.hessian, options.model_error, options.model_error_weight));
  return ToFit(posterior, minimum, static_cast<int>(samples.size()), 1);
}

}  // namespace gonio
