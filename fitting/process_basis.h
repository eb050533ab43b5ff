// SPDX-License-Identifier: Apache-2.0
// Smooth functions over all directions, as coefficients of one tensor basis.

#pragma once

#include <Eigen/Core>
#include <array>

#include "brdf/direction.h"
#include "fitting/spline.h"

namespace gonio {

// A function of (theta_h, theta_d, phi_d) as a sum of products:
//
//   g = sum_hdk c_hdk  B_h(u)  B_d(1 - cos theta_d)  H_k(phi_d, theta_h, theta_d)
//   u = log(1 + theta_h / 0.3 deg) / log(301)
//
// B: uniform cubic B-splines; half of those in theta_h serve the highlight, below 5 degrees, and
// those in theta_d stand densest towards grazing, where reflectance rises.
// H: 1, t cos 2 phi_d, t cos 4 phi_d, t cos phi_d with t = sqrt(sin theta_h sin theta_d), which
// fades phi_d out where it means nothing. The last is odd about phi_d = 90 degrees: tables that
// were measured are not quite as reciprocal as materials.
class ProcessBasis {
 public:
  static constexpr int kHarmonics = 4;
  static constexpr int kTerms = 4 * 4 * kHarmonics;  // that do not vanish at one place

  // How many splines over theta_h and theta_d, kMinKnots or more each.
  ProcessBasis(int theta_h_knots = 28, int theta_d_knots = 12)
      : theta_h_knots_(theta_h_knots), theta_d_knots_(theta_d_knots) {}

  bool operator==(const ProcessBasis&) const = default;
  int theta_h_knots() const { return theta_h_knots_; }
  int theta_d_knots() const { return theta_d_knots_; }
  int size() const { return theta_h_knots_ * theta_d_knots_ * kHarmonics; }
  int Index(int h, int d, int k) const { return (h * theta_d_knots_ + d) * kHarmonics + k; }

  // The terms at one place: g = sum_i weight[i] c[index[i]].
  struct Terms {
    std::array<int, kTerms> index;
    std::array<double, kTerms> weight;

    template <typename Coefficients>
    double Of(const Coefficients& c) const {
      double sum = 0;
      for (int i = 0; i < kTerms; ++i) sum += weight[i] * c[index[i]];
      return sum;
    }
    // The same for every column of a matrix of coefficients: one row of features.
    Eigen::VectorXd RowOf(const Eigen::MatrixXd& coefficients) const;
  };
  Terms At(const HalfDiff& angles) const;

 private:
  int theta_h_knots_;
  int theta_d_knots_;
};

}  // namespace gonio
