// SPDX-License-Identifier: Apache-2.0
#include "fitting/process_posterior.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "fitting/generalised_log.h"

namespace gonio {
namespace {

// A missing channel is taken to be as foretold, and to say nothing.
constexpr double kUnknown = 1e6;  // variance

// Variance of a channel's z.
Rgb NoiseOf(const ProcessReading& reading, const Rgb& f_r, double floor, double model_error) {
  Rgb noise;
  for (int c = 0; c < kChannels; ++c) {
    const double sensor = reading.sigma[c] * GeneralisedLogSlope(std::max(f_r[c], 0.0), floor);
    noise[c] = std::isfinite(sensor) ? sensor * sensor + model_error * model_error : kUnknown;
  }
  return noise;
}

}  // namespace

void ProcessOptions::Check() const {
  const auto require = [](bool holds, const char* name, const char* condition) {
    if (!holds) throw ConfigError(fmt::format("process.{}: must be {}", name, condition));
  };
  require(model_error >= 0 && std::isfinite(model_error), "model_error", ">= 0");
  require(repeatability >= 0 && std::isfinite(repeatability), "repeatability", ">= 0");
  require(huber > 0, "huber", "> 0");
  require(scale_weight >= 0, "scale_weight", ">= 0");
  require(!stationary_scales.empty(), "stationary_scales", "at least one number");
  for (const double scale : stationary_scales) require(scale > 0, "stationary_scales", "> 0");
}

// A reading in the model's series, less its mean.
struct ProcessPosterior::Problem {
  const ProcessReading* reading;
  Eigen::Vector3d residual;
  Eigen::Vector3d precision;  // 1 / variance of each series
};

ProcessPosterior::ProcessPosterior(const ProcessModel& model,
                                   std::span<const ProcessReading> readings,
                                   const ProcessOptions& options)
    : model_(model), groups_(model.groups().size()) {
  for (const ProcessModel::Group& group : model.groups()) {
    for (int s = group.first_series; s < group.first_series + group.series; ++s) {
      weights_[s] = Eigen::VectorXd::Zero(group.size);
    }
  }
  constexpr int kPasses = 3;
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<Problem> problems;
    problems.reserve(readings.size());
    for (const ProcessReading& reading : readings) {
      const Eigen::Vector3d foretold = Mean(reading.place);
      Rgb f_r;
      Eigen::Vector3d z;
      for (int c = 0; c < kChannels; ++c) {
        const bool known = std::isfinite(reading.sigma[c]);
        z[c] = known ? GeneralisedLog(reading.f_r[c], model.floor()) : foretold[c];
        f_r[c] =
            pass == 0 && known ? reading.f_r[c] : FromGeneralisedLog(foretold[c], model.floor());
      }
      const Rgb noise = NoiseOf(reading, f_r, model.floor(), options.model_error);
      Problem problem{&reading, model.transform() * z - reading.place.mean, {}};
      const Eigen::Matrix3d squared = model.transform().cwiseAbs2();
      // What is common to the channels adds up in a series to its row sum.
      const Eigen::Vector3d common = model.transform().rowwise().sum() * options.repeatability;
      const Eigen::Vector3d variance = squared * noise.matrix() + common.cwiseAbs2();
      problem.precision = variance.cwiseInverse();
      if (pass > 0) {
        const Eigen::Vector3d off = model.transform() * (z - foretold);
        for (int s = 0; s < kChannels; ++s) {
          const double normalised = std::abs(off[s]) * std::sqrt(problem.precision[s]);
          if (normalised > options.huber) problem.precision[s] *= options.huber / normalised;
        }
      }
      problems.push_back(problem);
    }
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      SolveGroup(static_cast<int>(g), problems, options, pass + 1 == kPasses);
    }
  }
}

void ProcessPosterior::SolveGroup(int group_index, const std::vector<Problem>& problems,
                                  const ProcessOptions& options, bool last) {
  const ProcessModel::Group& group = model_.groups()[group_index];
  const auto rows = static_cast<Eigen::Index>(problems.size());
  Eigen::MatrixXd features(group.size, rows);  // times the root of the precision
  Eigen::MatrixXd residuals(rows, group.series);
  for (Eigen::Index n = 0; n < rows; ++n) {
    const Problem& problem = problems[n];
    // Series of a group share a covariance, so a common precision.
    const double precision = problem.precision.segment(group.first_series, group.series).mean();
    features.col(n) = std::sqrt(precision) * problem.reading->place.features[group_index];
    residuals.row(n) = std::sqrt(precision) *
                       problem.residual.segment(group.first_series, group.series).transpose();
  }
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(group.size, group.size);
  if (rows > 0) information.selfadjointView<Eigen::Lower>().rankUpdate(features);
  Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(group.size, group.series);
  if (rows > 0) pull = features * residuals;
  const double squares = residuals.squaredNorm();
  const double count = static_cast<double>(rows) * group.series;
  double best = -std::numeric_limits<double>::infinity();
  Eigen::MatrixXd best_root;
  for (const double scale : options.stationary_scales) {
    // In units of weights of unit prior variance: S (G) S + 1, S = diag(1 .. 1, scale .. scale).
    Eigen::VectorXd s = Eigen::VectorXd::Ones(group.size);
    s.tail(group.size - group.learned).setConstant(scale);
    Eigen::MatrixXd precision = s.asDiagonal() * information * s.asDiagonal();
    precision.diagonal().array() += 1;
    const Eigen::LLT<Eigen::MatrixXd, Eigen::Lower> llt(precision);
    const Eigen::MatrixXd half = llt.matrixL().solve(s.asDiagonal() * pull);
    const double quadratic = std::max(squares - half.squaredNorm(), 0.0);
    const double log_det = 2 * llt.matrixLLT().diagonal().array().log().sum();
    const double weight = options.scale_weight;
    const double evidence =
        -0.5 * group.series * log_det -
        (weight > 0 ? 0.5 * (weight + count) * std::log1p(quadratic / weight) : 0.5 * quadratic);
    if (!(evidence > best)) continue;
    best = evidence;
    Knowledge& knowledge = groups_[group_index];
    knowledge.stationary_scale = scale;
    knowledge.scale = weight > 0 ? (weight + quadratic) / (weight + count) : 1;
    best_root = llt.matrixL();
    const Eigen::MatrixXd mean = s.asDiagonal() * llt.matrixU().solve(half);
    for (int k = 0; k < group.series; ++k) weights_[group.first_series + k] = mean.col(k);
  }
  if (last) SetCovariance(best_root, group, &groups_[group_index]);
}

// Of weights of which `factor`, lower triangular, is the root of the precision, in units of the
// chosen scale of the stationary part.
void ProcessPosterior::SetCovariance(const Eigen::MatrixXd& factor,
                                     const ProcessModel::Group& group, Knowledge* knowledge) {
  Eigen::MatrixXd units = Eigen::MatrixXd::Identity(group.size, group.size);
  units.diagonal().tail(group.size - group.learned).setConstant(knowledge->stationary_scale);
  const Eigen::MatrixXd root = factor.triangularView<Eigen::Lower>().solve(units);
  knowledge->covariance.setZero(group.size, group.size);
  knowledge->covariance.selfadjointView<Eigen::Lower>().rankUpdate(root.transpose(),
                                                                   knowledge->scale);
  knowledge->covariance.triangularView<Eigen::StrictlyUpper>() = knowledge->covariance.transpose();
}

Eigen::Vector3d ProcessPosterior::Mean(const ProcessModel::Place& place) const {
  Eigen::Vector3d series = place.mean;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const ProcessModel::Group& group = model_.groups()[g];
    for (int s = group.first_series; s < group.first_series + group.series; ++s) {
      series[s] += place.features[g].dot(weights_[s]);
    }
  }
  return model_.transform().transpose() * series;
}

Eigen::Vector3d ProcessPosterior::SeriesVariance(const ProcessModel::Place& place) const {
  Eigen::Vector3d variance;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const ProcessModel::Group& group = model_.groups()[g];
    const double v = place.features[g].dot(groups_[g].covariance * place.features[g]);
    variance.segment(group.first_series, group.series).setConstant(v);
  }
  return variance;
}

}  // namespace gonio
