// SPDX-License-Identifier: Apache-2.0
#include "fitting/process_posterior.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "fitting/generalised_log.h"
#include "fitting/weight_solver.h"

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

// Of `count` values, but for a constant: a Gaussian's, or a Student's that `weight` values' worth
// of belief in a scale of 1 make of it.
double LogEvidence(const WeightSolver& solver, double count, int series, double weight) {
  const double misfit =
      weight > 0 ? (weight + count) * std::log1p(solver.quadratic() / weight) : solver.quadratic();
  return -0.5 * (series * solver.log_determinant() + misfit);
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
  const double count = static_cast<double>(rows) * group.series;
  for (Eigen::Index n = 0; n < rows; ++n) {
    const Problem& problem = problems[n];
    // Series of a group share a covariance, so a common precision.
    const double precision = problem.precision.segment(group.first_series, group.series).mean();
    features.col(n) = std::sqrt(precision) * problem.reading->place.features[group_index];
    residuals.row(n) = std::sqrt(precision) *
                       problem.residual.segment(group.first_series, group.series).transpose();
  }
  WeightSolver solver(std::move(features), std::move(residuals), group.learned);
  Knowledge& knowledge = groups_[group_index];
  double best = -std::numeric_limits<double>::infinity();
  for (const double strength : options.stationary_scales) {
    solver.Solve(strength);
    const double evidence = LogEvidence(solver, count, group.series, options.scale_weight);
    if (!(evidence > best)) continue;
    best = evidence;
    knowledge.stationary_scale = strength;
  }
  solver.Solve(knowledge.stationary_scale);
  const double weight = options.scale_weight;
  knowledge.scale = weight > 0 ? (weight + solver.quadratic()) / (weight + count) : 1;
  const Eigen::MatrixXd mean = solver.Mean();
  for (int k = 0; k < group.series; ++k) weights_[group.first_series + k] = mean.col(k);
  if (last) knowledge.covariance = knowledge.scale * solver.Covariance();
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
