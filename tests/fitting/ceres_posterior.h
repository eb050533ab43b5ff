// SPDX-License-Identifier: Apache-2.0
// The posterior of fitting/posterior.h as a problem for Ceres, written from the formulas: a second
// opinion on what the minimum is, and on how long finding it may take.

#pragma once

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "brdf/brdf.h"
#include "fitting/posterior.h"
#include "fitting/prior.h"
#include "fitting/slice.h"
#include "fitting/spline.h"

namespace gonio {

// (glog(y) - glog(f)) / s of one channel of one reading; its parameters are the channel's.
class ReadingCost final : public ceres::CostFunction {
 public:
  ReadingCost(const DsbrdfShape& shape, const HalfDiff& angles, double f_r, double sigma,
              const PosteriorOptions& options)
      : shape_(shape),
        basis_(BasisAt(angles.theta_d, shape.knots)),
        log_cos_(LogCos(angles.theta_h)),
        floor_(options.floor),
        glog_(std::asinh(f_r / (2 * floor_))),
        s_(std::hypot(sigma / std::hypot(f_r, 2 * floor_), options.model_error)) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(shape.per_channel());
  }

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    const bool derive = jacobians != nullptr && jacobians[0] != nullptr;
    double f = 0;
    std::array<double, std::size_t{2} * kMaxLobes>
        slope{};  // of f with log kappa, log gamma of each lobe
    const double* coefficients = parameters[0];
    double* at = slope.data();
    for (int k = 0; k < shape_.lobes; ++k, at += 2) {
      const Logarithm log_kappa = Spline(coefficients, -14, 2.77);
      const Logarithm log_gamma = Spline(coefficients + shape_.knots, -4.6, 10.8);
      coefficients += shape_.knots + shape_.knots;
      const double exponent = log_cos_ * std::exp(log_gamma.number);
      const double x = std::exp(log_kappa.number + exponent);
      const double rise = std::expm1(x);
      f += rise;
      at[0] = log_kappa.held ? 0 : (rise + 1) * x;
      at[1] = log_gamma.held ? 0 : (rise + 1) * x * exponent;
    }
    residuals[0] = (glog_ - std::asinh(f / (2 * floor_))) / s_;
    if (!derive) return true;
    const double outer = -1 / (s_ * std::hypot(f, 2 * floor_));
    std::fill_n(jacobians[0], shape_.per_channel(), 0.0);
    for (int a = 0; a < 2 * shape_.lobes; ++a) {
      for (int j = 0; j < 4; ++j) {
        jacobians[0][a * shape_.knots + basis_.first + j] = outer * slope[a] * basis_.weight[j];
      }
    }
    return true;
  }

 private:
  struct Logarithm {
    double number;
    bool held;  // at its bound
  };

  // With the bounds of fitting/slice.cpp; without them Ceres finds other minima, at gamma = 1e-4.
  Logarithm Spline(const double* coefficients, double min, double max) const {
    double sum = 0;
    for (int j = 0; j < 4; ++j) sum += basis_.weight[j] * coefficients[basis_.first + j];
    return {std::clamp(sum, min, max), sum < min || sum > max};
  }

  DsbrdfShape shape_;
  SplineBasis basis_;
  double log_cos_;
  double floor_;
  double glog_;
  double s_;
};

// L^-1 (p - mean), L L' being the prior's covariance; half its square is the prior's cost.
class PriorCost final : public ceres::CostFunction {
 public:
  explicit PriorCost(const Prior& prior) : shape_(prior.shape), mean_(prior.mean) {
    const Eigen::Index size = mean_.size();
    root_ = prior.covariance.llt().matrixL().solve(Eigen::MatrixXd::Identity(size, size));
    set_num_residuals(shape_.size());
    mutable_parameter_block_sizes()->assign(kChannels, shape_.per_channel());
  }

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Index size = shape_.per_channel();
    Eigen::VectorXd deviation = -mean_;
    for (int c = 0; c < kChannels; ++c) {
      deviation.segment(c * size, size) += Eigen::Map<const Eigen::VectorXd>(parameters[c], size);
    }
    Eigen::Map<Eigen::VectorXd>(residuals, shape_.size()) = root_ * deviation;
    if (jacobians == nullptr) return true;
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    for (int c = 0; c < kChannels; ++c) {
      if (jacobians[c] == nullptr) continue;
      Eigen::Map<RowMajor>(jacobians[c], shape_.size(), size) = root_.middleCols(c * size, size);
    }
    return true;
  }

 private:
  DsbrdfShape shape_;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd root_;
};

struct CeresMinimum {
  Eigen::VectorXd parameters;
  double cost = 0;
  int iterations = 0;
  bool converged = false;
};

// Ends when a step lowers the cost by less than `tolerance` of it.
inline CeresMinimum MinimiseWithCeres(std::span<const BrdfSample> samples, const Prior& prior,
                                      const PosteriorOptions& options, const Eigen::VectorXd& start,
                                      int max_iterations, double tolerance) {
  const DsbrdfShape& shape = prior.shape;
  CeresMinimum minimum{.parameters = start};
  std::array<double*, kChannels> blocks;
  for (int c = 0; c < kChannels; ++c) {
    blocks[c] = minimum.parameters.data() + shape.Index(c, 0, 0);
  }
  ceres::HuberLoss huber(options.huber);
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (const BrdfSample& sample : samples) {
    const HalfDiff angles = ToHalfDiff(sample.directions);
    for (int c = 0; c < kChannels; ++c) {
      if (!std::isfinite(sample.sigma[c])) continue;
      problem.AddResidualBlock(
          new ReadingCost(shape, angles, sample.f_r[c], sample.sigma[c], options), &huber,
          blocks[c]);
    }
  }
  problem.AddResidualBlock(new PriorCost(prior), nullptr, blocks[0], blocks[1], blocks[2]);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = max_iterations;
  solver.function_tolerance = tolerance;
  solver.parameter_tolerance = 0;
  solver.gradient_tolerance = 0;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  minimum.cost = summary.final_cost;
  minimum.iterations = static_cast<int>(summary.iterations.size()) - 1;
  minimum.converged = summary.termination_type == ceres::CONVERGENCE;
  return minimum;
}

}  // namespace gonio
