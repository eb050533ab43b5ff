// SPDX-License-Identifier: Apache-2.0
#include "fitting/hemi_epd.h"

#include "core/check.h"
#include "core/units.h"

namespace gonio {

double LogHemisphereIntegral(const Lobe& lobe) {
  GONIO_CHECK(lobe.kappa > 0 && lobe.gamma > 0, "a lobe's kappa and gamma are positive");
  const double log_kappa = std::log(lobe.kappa);
  // The terms rise up to m about kappa and then fall faster than a Gaussian of variance kappa.
  // Summed from the largest outwards, relative to it, nothing overflows.
  const auto log_term = [&](double m) {
    return m * log_kappa - std::lgamma(m + 1) - std::log(lobe.gamma * m + 1);
  };
  const double middle = std::max(1.0, std::floor(lobe.kappa));
  const double log_middle = log_term(middle);
  constexpr double kNegligible = 1e-17;
  double sum = 1;
  // Neighbouring terms by their ratio, which is exact where lgamma is not.
  double term = 1;
  for (double m = middle; term > kNegligible * sum; ++m) {
    term *= lobe.kappa / (m + 1) * (lobe.gamma * m + 1) / (lobe.gamma * (m + 1) + 1);
    sum += term;
  }
  term = 1;
  for (double m = middle; m > 1 && term > kNegligible * sum; --m) {
    term *= m / lobe.kappa * (lobe.gamma * m + 1) / (lobe.gamma * (m - 1) + 1);
    sum += term;
  }
  return std::log(2 * kPi) + log_middle + std::log(sum);
}

void BoundedLobe::Fill(const Eigen::ArrayXd& log_cos, Columns* columns) const {
  const auto begin = log_cos.begin();
  const Eigen::Index n =
      std::partition_point(begin, log_cos.end(),
                           [&](double at) { return lobe_.gamma * at > kVanished; }) -
      begin;
  columns->resize(log_cos.size(), 3);
  columns->bottomRows(log_cos.size() - n).setZero();
  auto f_r = columns->col(0).head(n);
  auto by_log_kappa = columns->col(1).head(n);
  auto by_log_gamma = columns->col(2).head(n);
  by_log_gamma = lobe_.gamma * log_cos.head(n);
  by_log_kappa = lobe_.kappa * by_log_gamma.exp();
  f_r = by_log_kappa.exp();
  by_log_kappa *= f_r;
  by_log_gamma *= by_log_kappa;
  f_r -= 1;
  if (kappa_held_) by_log_kappa.setZero();
  if (gamma_held_) by_log_gamma.setZero();
}

double LogLobe(const Lobe& lobe, double log_cos) {
  const double log_x = std::log(lobe.kappa) + lobe.gamma * log_cos;
  const double x = std::exp(log_x);
  if (x < 1e-8) return log_x + x / 2;  // log(expm1(x)) = log x + x/2 + O(x^2)
  return x + std::log1p(-std::exp(-x));
}

}  // namespace gonio
