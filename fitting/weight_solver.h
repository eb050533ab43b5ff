// SPDX-License-Identifier: Apache-2.0
// Linear weights with a Gaussian prior, seen through readings: the algebra of a process.

#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace gonio {

// Readings v = F' w + noise of unit variance, of weights w that are independent and N(0, 1), but
// for those after the first `learned`, which are N(0, strength^2). Several columns of v are as many
// weight vectors of one covariance.
//
// Solved in the space of the readings while they are fewer than the weights, else in that of the
// weights (Rasmussen & Williams, "Gaussian Processes for Machine Learning", 2006, section 2.1.2):
// the numbers are the same, the cost is the smaller of the two.
class WeightSolver {
 public:
  // features: weights x readings; values: readings x series. There may be no reading.
  WeightSolver(Eigen::MatrixXd features, Eigen::MatrixXd values, Eigen::Index learned);

  // What follows holds for this strength, > 0. To be called first.
  void Solve(double strength);

  // Of the values' covariance matrix C = F' S^2 F + 1: log |C| and sum of v' C^-1 v.
  double log_determinant() const { return log_determinant_; }
  double quadratic() const { return quadratic_; }
  // Of the weights, given the values: a column for each series, and the covariance of each.
  Eigen::MatrixXd Mean() const;
  Eigen::MatrixXd Covariance() const;

 private:
  void SolveReadings();
  void SolveWeights();

  Eigen::MatrixXd features_;
  Eigen::MatrixXd values_;
  Eigen::Index learned_;
  bool by_readings_;
  // In the space of readings: F' F of the learned weights and of the others.
  Eigen::MatrixXd gram_learned_;
  Eigen::MatrixXd gram_others_;
  // In that of weights: F F' (lower half) and F v.
  Eigen::MatrixXd information_;
  Eigen::MatrixXd pull_;

  Eigen::VectorXd spread_;  // S
  Eigen::LLT<Eigen::MatrixXd, Eigen::Lower> llt_;
  Eigen::MatrixXd half_;  // right hand side, half solved
  double log_determinant_ = 0;
  double quadratic_ = 0;
};

}  // namespace gonio
