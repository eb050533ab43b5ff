// SPDX-License-Identifier: Apache-2.0
#include "fitting/slice.h"

#include <algorithm>
#include <cmath>

namespace gonio {
namespace {

// Bounds far outside what materials show, so that no step of an optimiser overflows:
// exp(kappa) - 1 is the lobe's height, so kappa = 16 is f_r = 9e6 / sr.
constexpr double kMinLogKappa = -14;
constexpr double kMaxLogKappa = 2.77;
constexpr double kMinLogGamma = -4.6;  // 0.01: constant to 89.9 degrees
constexpr double kMaxLogGamma = 10.8;  // 50,000: half a degree wide

// Above this a lobe has vanished: cos^gamma < exp(-40).
constexpr double kVanished = -40;

}  // namespace

double LogCos(double theta_h) { return std::log(std::max(std::cos(theta_h), 1e-9)); }

Slice::Slice(const DsbrdfShape& shape, const Eigen::VectorXd& parameters, double theta_d)
    : lobe_count_(shape.lobes), basis_(BasisAt(theta_d, shape.knots)) {
  const auto spline = [&](int index) {
    const double* coefficient = parameters.data() + index + basis_.first;
    double sum = 0;
    for (int j = 0; j < 4; ++j) sum += basis_.weight[j] * coefficient[j];
    return sum;
  };
  for (int c = 0; c < kChannels; ++c) {
    for (int k = 0; k < shape.lobes; ++k) {
      const double log_kappa = spline(shape.Index(c, k, 0));
      const double log_gamma = spline(shape.Index(c, k, 1));
      Lobe& lobe = lobes_[c][k];
      lobe.kappa = std::exp(std::clamp(log_kappa, kMinLogKappa, kMaxLogKappa));
      lobe.gamma = std::exp(std::clamp(log_gamma, kMinLogGamma, kMaxLogGamma));
      lobe.kappa_held = log_kappa < kMinLogKappa || log_kappa > kMaxLogKappa;
      lobe.gamma_held = log_gamma < kMinLogGamma || log_gamma > kMaxLogGamma;
    }
  }
}

double Slice::Eval(int channel, double log_cos) const {
  double f = 0;
  for (int k = 0; k < lobe_count_; ++k) {
    const Lobe& lobe = lobes_[channel][k];
    const double exponent = lobe.gamma * log_cos;
    if (exponent > kVanished) f += std::expm1(lobe.kappa * std::exp(exponent));
  }
  return f;
}

double Slice::EvalWithGradient(int channel, double log_cos, double* gradient) const {
  double f = 0;
  for (int k = 0; k < lobe_count_; ++k) {
    const Lobe& lobe = lobes_[channel][k];
    const double exponent = lobe.gamma * log_cos;
    double& by_kappa = gradient[2 * k];
    double& by_gamma = gradient[2 * k + 1];
    by_kappa = by_gamma = 0;
    if (exponent <= kVanished) continue;
    const double x = lobe.kappa * std::exp(exponent);  // kappa cos^gamma
    const double rise = std::expm1(x);
    f += rise;
    const double slope = (rise + 1) * x;  // d f / d log kappa
    if (!lobe.kappa_held) by_kappa = slope;
    if (!lobe.gamma_held) by_gamma = slope * exponent;
  }
  return f;
}

}  // namespace gonio
