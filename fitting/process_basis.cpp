// SPDX-License-Identifier: Apache-2.0
#include "fitting/process_basis.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace gonio {
namespace {

constexpr double kHighlight = RadFromDeg(0.3);

}  // namespace

ProcessBasis::Terms ProcessBasis::At(const HalfDiff& angles) const {
  const double u =
      std::log1p(std::max(angles.theta_h, 0.0) / kHighlight) / std::log1p(kPi / 2 / kHighlight);
  const SplineBasis h = UnitBasisAt(u, theta_h_knots_);
  const SplineBasis d = UnitBasisAt(1 - std::cos(angles.theta_d), theta_d_knots_);
  const double fade = std::sqrt(std::max(std::sin(angles.theta_h) * std::sin(angles.theta_d), 0.0));
  const double cos1 = std::cos(angles.phi_d);
  const double cos2 = 2 * cos1 * cos1 - 1;
  const double harmonic[kHarmonics] = {1, fade * cos2, fade * (2 * cos2 * cos2 - 1), fade * cos1};
  Terms terms;
  int i = 0;
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b < 4; ++b) {
      const double product = h.weight[a] * d.weight[b];
      for (int k = 0; k < kHarmonics; ++k, ++i) {
        terms.index[i] = Index(h.first + a, d.first + b, k);
        terms.weight[i] = product * harmonic[k];
      }
    }
  }
  return terms;
}

Eigen::VectorXd ProcessBasis::Terms::RowOf(const Eigen::MatrixXd& coefficients) const {
  // Coefficients of one place stand in runs of consecutive rows; the transpose of such a run times
  // its weights is what vectorises.
  constexpr int kRun = 4 * kHarmonics;
  Eigen::VectorXd row = Eigen::VectorXd::Zero(coefficients.cols());
  for (int i = 0; i < kTerms; i += kRun) {
    const Eigen::Map<const Eigen::VectorXd> run(&weight[i], kRun);
    row.noalias() += coefficients.middleRows(index[i], kRun).transpose() * run;
  }
  return row;
}

}  // namespace gonio
