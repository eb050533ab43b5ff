// SPDX-License-Identifier: Apache-2.0
// What is believed of a material's whole reflectance, learned from other materials.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "fitting/process_basis.h"

namespace gonio {

// How much wider or narrower than a Gaussian's a central interval has to be.
struct Calibration {
  double probability = 0;  // 0 .. 1, exclusive
  double widening = 1;     // > 0
};

// A Gaussian process over z = glog(f_r) (fitting/generalised_log.h) of the three channels:
//
//   y = T z,  y_0 = (z_r + z_g + z_b) / sqrt(3): luminance;  y_1, y_2: chroma, any orthonormal pair
//   y_0 = mean + sum_i luminance_i w_i + stationary,   y_1, y_2 = sum_i chroma_i w_i + stationary
//
// with independent standard normal weights w. Splitting colours so costs nothing in a mirror peak,
// which most materials have in the same height in all channels, and spares the planner a third of
// its work, as both chroma series share one covariance.
//
// The components are principal ones of the training materials: whatever these do, the process can
// do. The stationary part is what a material may do that none of them did (docs/fitting.md).
struct ProcessPrior {
  static constexpr double kUncalibratedMargin = 1.5;  // usual where it was measured

  ProcessBasis basis;
  double floor = 0.02;        // 1/sr, of glog
  Eigen::VectorXd mean;       // basis.size() coefficients
  Eigen::MatrixXd luminance;  // basis.size() x components, each scaled by its standard deviation
  Eigen::MatrixXd chroma;     // basis.size() x components
  // Standard deviation of the stationary part of each coefficient, basis.size().
  Eigen::VectorXd stationary_luminance;
  Eigen::VectorXd stationary_chroma;
  // From sessions on training materials that the process was not learned from (planner/
  // prior_calibration.h): intervals by probability, none meaning Gaussian ones, and by how much the
  // expected error must be raised for most sessions to end up below it, > 0.
  std::vector<Calibration> calibration;
  double error_margin = kUncalibratedMargin;
};

// Components of a stationary part: its coefficients have these standard deviations and a Gaussian
// correlation along theta_h and theta_d, none between terms of different phi_d. The `count`
// columns, basis.size() rows each, are those of a pivoted Cholesky decomposition (Harbrecht, Peters
// & Schneider, "On the low-rank approximation by the pivoted Cholesky decomposition", 2012).
Eigen::MatrixXd StationaryComponents(const ProcessBasis& basis, const Eigen::VectorXd& spread,
                                     int count);

// T above: rows are luminance and two chroma series, columns red, green, blue. Orthonormal.
Eigen::Matrix3d LuminanceAndChroma();

}  // namespace gonio
