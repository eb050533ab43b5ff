// SPDX-License-Identifier: Apache-2.0
#include "fitting/process_prior.h"

#include <algorithm>
#include <cmath>

namespace gonio {
namespace {

// Correlation lengths along the basis's two warped angles, both 0 .. 1.
constexpr double kLengthH = 0.12;
constexpr double kLengthD = 0.25;
// Gaussian correlations of spline coefficients `spacing` apart.
Eigen::MatrixXd Correlation(int knots, double length) {
  Eigen::MatrixXd correlation(knots, knots);
  for (int i = 0; i < knots; ++i) {
    for (int j = 0; j < knots; ++j) {
      const double distance = (i - j) / (length * (knots - 3));
      correlation(i, j) = std::exp(-0.5 * distance * distance);
    }
  }
  return correlation;
}

}  // namespace

Eigen::MatrixXd StationaryComponents(const ProcessBasis& basis, const Eigen::VectorXd& spread,
                                     int count) {
  const Eigen::MatrixXd along_h = Correlation(basis.theta_h_knots(), kLengthH);
  const Eigen::MatrixXd along_d = Correlation(basis.theta_d_knots(), kLengthD);
  Eigen::MatrixXd components = Eigen::MatrixXd::Zero(basis.size(), count);
  Eigen::VectorXd left = spread.cwiseAbs2();  // variance not yet in a component
  Eigen::VectorXd covariance(basis.size());   // with the pivot
  for (int n = 0; n < count; ++n) {
    Eigen::Index pivot = 0;
    const double variance = left.maxCoeff(&pivot);
    if (!(variance > 1e-12)) return components.leftCols(n);
    covariance.setZero();
    const auto k = static_cast<int>(pivot % ProcessBasis::kHarmonics);
    const auto cell = static_cast<int>(pivot / ProcessBasis::kHarmonics);
    for (int h = 0; h < basis.theta_h_knots(); ++h) {
      for (int d = 0; d < basis.theta_d_knots(); ++d) {
        const int i = basis.Index(h, d, k);
        covariance[i] = spread[i] * spread[pivot] * along_h(h, cell / basis.theta_d_knots()) *
                        along_d(d, cell % basis.theta_d_knots());
      }
    }
    covariance -= components.leftCols(n) * components.row(pivot).head(n).transpose();
    components.col(n) = covariance / std::sqrt(variance);
    left = (left - components.col(n).cwiseAbs2()).cwiseMax(0);
  }
  return components;
}

Eigen::Matrix3d LuminanceAndChroma() {
  Eigen::Matrix3d t;
  t << 1, 1, 1, 1, -1, 0, 1, 1, -2;
  t.row(0) /= std::sqrt(3.0);
  t.row(1) /= std::sqrt(2.0);
  t.row(2) /= std::sqrt(6.0);
  return t;
}

}  // namespace gonio
