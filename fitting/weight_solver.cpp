// SPDX-License-Identifier: Apache-2.0
#include "fitting/weight_solver.h"

#include <algorithm>
#include <utility>

namespace gonio {
namespace {

// A A', of which the lower half is computed, or all of it.
Eigen::MatrixXd LowerSquare(const Eigen::Ref<const Eigen::MatrixXd>& a) {
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(a.rows(), a.rows());
  if (a.cols() > 0) square.selfadjointView<Eigen::Lower>().rankUpdate(a);
  return square;
}

void MirrorLower(Eigen::MatrixXd* matrix) {
  matrix->triangularView<Eigen::StrictlyUpper>() = matrix->transpose();
}

}  // namespace

WeightSolver::WeightSolver(Eigen::MatrixXd features, Eigen::MatrixXd values, Eigen::Index learned)
    : features_(std::move(features)),
      values_(std::move(values)),
      learned_(learned),
      by_readings_(features_.cols() > 0 && features_.cols() < features_.rows()) {
  if (by_readings_) {
    gram_learned_ = LowerSquare(features_.topRows(learned_).transpose());
    gram_others_ = LowerSquare(features_.bottomRows(features_.rows() - learned_).transpose());
  } else {
    information_ = LowerSquare(features_);
    pull_ = Eigen::MatrixXd::Zero(features_.rows(), values_.cols());
    if (features_.cols() > 0) pull_ += features_ * values_;  // Eigen must not see empty products
  }
}

void WeightSolver::Solve(double strength) {
  spread_ = Eigen::VectorXd::Ones(features_.rows());
  spread_.tail(features_.rows() - learned_).setConstant(strength);
  by_readings_ ? SolveReadings() : SolveWeights();
  log_determinant_ = 2 * llt_.matrixLLT().diagonal().array().log().sum();
}

void WeightSolver::SolveReadings() {
  const double strength = spread_.tail(1)[0];
  Eigen::MatrixXd covariance = gram_learned_ + strength * strength * gram_others_;
  covariance.diagonal().array() += 1;
  llt_.compute(covariance);
  half_ = llt_.matrixL().solve(values_);
  quadratic_ = half_.squaredNorm();
}

// In units of weights of unit prior variance: S F F' S + 1.
void WeightSolver::SolveWeights() {
  Eigen::MatrixXd precision = spread_.asDiagonal() * information_ * spread_.asDiagonal();
  precision.diagonal().array() += 1;
  llt_.compute(precision);
  half_ = llt_.matrixL().solve(spread_.asDiagonal() * pull_);
  quadratic_ = std::max(values_.squaredNorm() - half_.squaredNorm(), 0.0);
}

Eigen::MatrixXd WeightSolver::Mean() const {
  const Eigen::MatrixXd solved = llt_.matrixU().solve(half_);
  if (!by_readings_) return spread_.asDiagonal() * solved;
  return spread_.cwiseAbs2().asDiagonal() * (features_ * solved);
}

Eigen::MatrixXd WeightSolver::Covariance() const {
  Eigen::MatrixXd covariance;
  if (by_readings_) {
    const Eigen::MatrixXd known =
        llt_.matrixL().solve(features_.transpose() * spread_.cwiseAbs2().asDiagonal());
    covariance = -LowerSquare(known.transpose());
    covariance.diagonal() += spread_.cwiseAbs2();
  } else {
    const Eigen::MatrixXd units = spread_.asDiagonal();
    const Eigen::MatrixXd root = llt_.matrixL().solve(units);
    covariance = LowerSquare(root.transpose());
  }
  MirrorLower(&covariance);
  return covariance;
}

}  // namespace gonio
