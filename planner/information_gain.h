// SPDX-License-Identifier: Apache-2.0
// How much a measurement would teach: the expected drop of predictive variance.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "fitting/fit.h"
#include "fitting/spline.h"
#include "planner/candidates.h"
#include "planner/image_parts.h"

namespace gonio {

// What a planner minimises: the weighted sum over directions of the variance of
//
//   kMale      ln(1 + f_r cos theta_i), the quantity of the headline metric (brdf/metrics.h)
//   kRelative  log f_r (with the fit's floor)
//
// A direction counts by the share of (theta_h, theta_d, phi_d) it stands for, uniform in angle.
enum class Objective { kMale, kRelative };

struct GainOptions {
  Objective objective = Objective::kMale;
  double max_polar = 1.3962634;   // rad (80 deg): directions nearer to the horizon do not count
  double relative_noise = 0.015;  // > 0: relative sigma expected of a reading
  // How far the part of log f_r that no DSBRDF explains reaches, on the unit square of
  // (sqrt(theta_h / 90 deg), theta_d / 90 deg): nearer readings repeat it. > 0.
  double repeat_length = 0.02;
  PartsOf parts = {};  // what else the image of a pose shows
};

// The state of knowledge, as far as a planner needs it.
struct GainScores {
  // Per candidate: the share of the objective (0 .. 1) its measurement is expected to take away.
  Eigen::VectorXd gain;
  // Mean absolute error of the objective's quantity to be expected of the fit as it is.
  double predicted_error = 0;
};

// Scores candidates under the Gaussian (Laplace) posterior of a fit (D. MacKay, "Information-Based
// Objective Functions for Active Data Selection", 1992; the criterion is Bayesian I-optimality):
//
//   gain(x) = trace((J P J' + R)^-1 J P A P J') / trace(A P)
//
// J: Jacobian of the three channels' log f_r at x; P: parameter covariance; A: weighted sum of the
// outer products of the objective's gradients; R: noise and model error. A DSBRDF sees theta_d only
// through its splines, so P and P A P are projected once per theta_d column of the raster, and a
// candidate then costs a few hundred operations.
//
// Where an image holds several samples, J has three rows for each of them, and R their noise: one
// draw of relative_noise for each channel of the image, so that parts do not average it out. Such a
// gain costs far more; it is found for the scouts of ImageParts and for the
// candidates that would teach most by their middle. The others keep what their middle would teach,
// which is less.
class InformationGain {
 public:
  InformationGain(std::vector<Candidate> candidates, const GainOptions& options);
  InformationGain(const InformationGain&) = delete;
  InformationGain& operator=(const InformationGain&) = delete;

  // `measured`: indices of the candidates measured so far, repeats included.
  GainScores Evaluate(const DsbrdfFit& fit, const std::vector<int>& measured) const;

  const std::vector<Candidate>& candidates() const { return candidates_; }

 private:
  struct Column {  // candidates that share a theta_d
    double theta_d;
    std::vector<int> members;
  };
  struct Target {       // what a candidate's cell counts in the objective
    double weight = 0;  // sums to 1 over the candidates
    double cosine = 0;  // mean cos theta_i over the phi_d that count
    double log_cos = 0;
  };
  struct Linearisation;

  Linearisation Linearise(const DsbrdfFit& fit) const;
  // trace(A P) and the predicted error come on the side.
  Eigen::MatrixXd ObjectiveMatrix(const DsbrdfFit& fit, const Linearisation& at, double* variance,
                                  double* predicted_error) const;
  // Puts the gains of whole images into `scores`.
  void ScoreImages(const DsbrdfFit& fit, const Linearisation& at, const Eigen::MatrixXd& taught,
                   const std::vector<int>& measured, double variance, GainScores* scores) const;
  double ImageGain(const DsbrdfFit& fit, const Linearisation& at, const Eigen::MatrixXd& taught,
                   const std::vector<int>& parts, const std::vector<int>& measured) const;
  // 1 + the number of measured neighbours, each weighted by how near it is.
  double Crowding(int candidate, const std::vector<int>& measured) const;

  std::vector<Candidate> candidates_;
  GainOptions options_;
  std::vector<Column> columns_;
  std::vector<Target> targets_;
  std::vector<int> column_of_;  // of each candidate: its place in columns_
  ImageParts parts_;
};

}  // namespace gonio
