// SPDX-License-Identifier: Apache-2.0
#include "fitting/posterior.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "fitting/generalised_log.h"
#include "fitting/slice.h"

namespace gonio {
namespace {

using SliceGradient = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 2 * kMaxLobes, 1>;
using SliceHessian =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2 * kMaxLobes, 2 * kMaxLobes>;

// Huber's loss of a normalised residual, and the weight iteratively reweighted least squares gives.
double HuberLoss(double r, double k) {
  const double a = std::abs(r);
  return a <= k ? 0.5 * r * r : k * (a - 0.5 * k);
}
double HuberWeight(double r, double k) {
  const double a = std::abs(r);
  return a <= k ? 1.0 : k / a;
}

// Adds a slice's gradient and Hessian of one channel to those of the spline coefficients.
void Spread(const DsbrdfShape& shape, int channel, const SplineBasis& basis,
            const SliceGradient& slice_gradient, const SliceHessian& slice_hessian,
            Eigen::VectorXd* gradient, Eigen::MatrixXd* hessian) {
  const int quantities = 2 * shape.lobes;
  const int offset = shape.Index(channel, 0, 0) + basis.first;
  const Eigen::Map<const Eigen::Vector4d> weight(basis.weight.data());
  const Eigen::Matrix4d outer = weight * weight.transpose();
  for (int a = 0; a < quantities; ++a) {
    const int row = offset + a * shape.knots;
    gradient->segment<4>(row) += slice_gradient[a] * weight;
    for (int b = 0; b <= a; ++b) {
      hessian->block<4, 4>(row, offset + b * shape.knots) += slice_hessian(a, b) * outer;
    }
  }
}

}  // namespace

Posterior::Posterior(std::span<const BrdfSample> samples, const Prior& prior,
                     const PosteriorOptions& options)
    : prior_(&prior), options_(options) {
  const int size = prior.shape.size();
  precision_ = prior.covariance.llt().solve(Eigen::MatrixXd::Identity(size, size));
  std::vector<std::pair<HalfDiff, const BrdfSample*>> ordered;
  ordered.reserve(samples.size());
  for (const BrdfSample& sample : samples) {
    ordered.emplace_back(ToHalfDiff(sample.directions), &sample);
  }
  std::stable_sort(ordered.begin(), ordered.end(),
                   [](const auto& a, const auto& b) { return a.first.theta_d < b.first.theta_d; });
  // Readings of one raster column differ in theta_d by rounding only.
  constexpr double kSameThetaD = 1e-9;
  for (const auto& [angles, sample] : ordered) {
    const int before = residual_count();
    for (int c = 0; c < kChannels; ++c) {
      if (!std::isfinite(sample->sigma[c])) continue;
      const double noise = sample->sigma[c] * GeneralisedLogSlope(sample->f_r[c], options_.floor);
      rows_.push_back({c, LogCos(angles.theta_h), GeneralisedLog(sample->f_r[c], options_.floor),
                       noise * noise, 0});
    }
    if (residual_count() == before) continue;
    if (groups_.empty() || angles.theta_d - groups_.back().theta_d > kSameThetaD) {
      groups_.push_back({angles.theta_d, before, before});
    }
    groups_.back().end = residual_count();
  }
  set_model_error(options_.model_error);
}

void Posterior::set_model_error(double model_error) {
  options_.model_error = model_error;
  for (Row& row : rows_) row.weight = 1 / (row.noise2 + model_error * model_error);
}

double Posterior::PriorCost(const Eigen::VectorXd& parameters, Eigen::VectorXd* pull) const {
  const Eigen::VectorXd deviation = parameters - prior_->mean;
  *pull = precision_ * deviation;
  return 0.5 * deviation.dot(*pull);
}

double Posterior::Cost(const Eigen::VectorXd& parameters) const {
  Eigen::VectorXd pull;
  double cost = PriorCost(parameters, &pull);
  for (const Group& group : groups_) {
    const Slice slice(prior_->shape, parameters, group.theta_d);
    for (int n = group.begin; n < group.end; ++n) {
      const Row& row = rows_[n];
      const double f = slice.Eval(row.channel, row.log_cos);
      const double r = (row.glog - GeneralisedLog(f, options_.floor)) * std::sqrt(row.weight);
      cost += HuberLoss(r, options_.huber);
    }
  }
  return cost;
}

double Posterior::Linearise(const Eigen::VectorXd& parameters, Eigen::VectorXd* gradient,
                            Eigen::MatrixXd* hessian) const {
  const DsbrdfShape& shape = prior_->shape;
  double cost = PriorCost(parameters, gradient);
  *hessian = precision_;
  const int quantities = 2 * shape.lobes;
  std::array<SliceGradient, kChannels> slice_gradient;
  std::array<SliceHessian, kChannels> slice_hessian;
  SliceGradient jacobian(quantities);
  for (const Group& group : groups_) {
    const Slice slice(shape, parameters, group.theta_d);
    for (int c = 0; c < kChannels; ++c) {
      slice_gradient[c].setZero(quantities);
      slice_hessian[c].setZero(quantities, quantities);
    }
    for (int n = group.begin; n < group.end; ++n) {
      const Row& row = rows_[n];
      const double f = slice.EvalWithGradient(row.channel, row.log_cos, jacobian.data());
      jacobian *= GeneralisedLogSlope(f, options_.floor);
      const double difference = row.glog - GeneralisedLog(f, options_.floor);
      const double r = difference * std::sqrt(row.weight);
      cost += HuberLoss(r, options_.huber);
      const double weight = row.weight * HuberWeight(r, options_.huber);
      slice_gradient[row.channel] -= weight * difference * jacobian;
      slice_hessian[row.channel].noalias() += weight * jacobian * jacobian.transpose();
    }
    for (int c = 0; c < kChannels; ++c) {
      Spread(shape, c, slice.basis(), slice_gradient[c], slice_hessian[c], gradient, hessian);
    }
  }
  // Only the lower triangle was filled.
  hessian->triangularView<Eigen::StrictlyUpper>() = hessian->transpose();
  return cost;
}

double Posterior::EstimateModelError(const Eigen::VectorXd& parameters,
                                     const Eigen::MatrixXd& hessian, double guess,
                                     double guess_weight) const {
  // Effective parameters = size - trace(hessian^-1 precision).
  const double free = prior_->shape.size() - hessian.llt().solve(precision_).trace();
  double squares = 0;
  double count = 0;
  for (const Group& group : groups_) {
    const Slice slice(prior_->shape, parameters, group.theta_d);
    for (int n = group.begin; n < group.end; ++n) {
      const Row& row = rows_[n];
      const double f = slice.Eval(row.channel, row.log_cos);
      const double difference = row.glog - GeneralisedLog(f, options_.floor);
      const double weight = HuberWeight(difference * std::sqrt(row.weight), options_.huber);
      squares += weight * (difference * difference - row.noise2);
      count += weight;
    }
  }
  const double degrees = std::max(count - free, 0.0);
  const double variance =
      (std::max(squares, 0.0) + guess_weight * guess * guess) / (degrees + guess_weight);
  return std::sqrt(variance);
}

}  // namespace gonio
