// SPDX-License-Identifier: Apache-2.0
// The function a fit minimises: noise-weighted robust residuals in log f_r plus a Gaussian prior.

#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "brdf/brdf.h"
#include "fitting/prior.h"

namespace gonio {

struct PosteriorOptions {
  double floor = 0.01;        // 1/sr, > 0: below this, absolute errors count, not relative ones
  double huber = 2.0;         // normalised residuals beyond this count linearly; > 0
  double model_error = 0.05;  // standard deviation of log f_r that no DSBRDF can explain, >= 0
};

// Negative log posterior of the parameters of a Dsbrdf, up to a constant:
//
//   sum_n rho((glog(y_n) - glog(f(x_n))) / s_n) + 1/2 (p - mean)' precision (p - mean)
//   s_n^2 = (sigma_n glog'(y_n))^2 + model_error^2,   rho(r) = Huber's loss, r^2 / 2 near zero
//
// Rows are grouped by theta_d, which the splines depend on; a raster with few distinct theta_d is
// therefore much cheaper than as many scattered poses.
class Posterior {
 public:
  // Channels with infinite sigma are left out. Samples with cos <= 0 must not occur.
  Posterior(std::span<const BrdfSample> samples, const Prior& prior,
            const PosteriorOptions& options);

  double Cost(const Eigen::VectorXd& parameters) const;
  // The same, with the gradient and the Gauss-Newton approximation of the Hessian (both prior
  // included), the latter with Huber's weights: its inverse is the Laplace covariance.
  double Linearise(const Eigen::VectorXd& parameters, Eigen::VectorXd* gradient,
                   Eigen::MatrixXd* hessian) const;

  // Standard deviation of log f_r beyond the samples' own sigma that the residuals at `parameters`
  // suggest, given the covariance there: sum of squares over residuals less effective parameters
  // (MacKay, "Bayesian Interpolation", 1992), pulled towards `guess` by `guess_weight` residuals.
  double EstimateModelError(const Eigen::VectorXd& parameters, const Eigen::MatrixXd& hessian,
                            double guess, double guess_weight) const;

  int residual_count() const { return static_cast<int>(rows_.size()); }
  const Prior& prior() const { return *prior_; }
  const PosteriorOptions& options() const { return options_; }
  void set_model_error(double model_error);

 private:
  struct Row {
    int channel;
    double log_cos;
    double glog;    // of the reading
    double noise2;  // variance of glog from the sample's sigma
    double weight;  // 1 / s^2
  };
  struct Group {  // rows that share a theta_d: [begin, end)
    double theta_d;
    int begin;
    int end;
  };

  template <typename RowFunction>
  void ForEachRow(const Eigen::VectorXd& parameters, const RowFunction& row_function) const;
  double PriorCost(const Eigen::VectorXd& parameters, Eigen::VectorXd* pull) const;

  const Prior* prior_;
  Eigen::MatrixXd precision_;
  PosteriorOptions options_;
  std::vector<Row> rows_;
  std::vector<Group> groups_;
};

}  // namespace gonio
