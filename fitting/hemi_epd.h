// SPDX-License-Identifier: Apache-2.0
// The lobe of a DSBRDF: Nishino's hemispherical exponential power distribution (Hemi-EPD).

#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "fitting/lobe_model.h"

namespace gonio {

// As a density over the hemisphere of half vectors (Nishino, "Directional Statistics BRDF Model",
// ICCV 2009; Edahiro et al., eq. 4 and 5):
//
//   p(theta_h | kappa, gamma) = C(kappa, gamma) (exp(kappa cos^gamma theta_h) - 1)
//
// With u = cos theta_h and the exponential's series, the integral that C is the inverse of is
//
//   2 pi int_0^1 (exp(kappa u^gamma) - 1) du = 2 pi sum_{m >= 1} kappa^m / (m! (gamma m + 1)).
//
// All terms are positive, so the sum loses no digits; the incomplete gamma functions of the papers
// are the same number, but cancel for small kappa. In the sign convention of the papers (kappa < 0)
// replace kappa by -kappa.

// log of that integral, 1 / C. Finite for kappa from 1e-300 to 1e5 and any gamma > 0; relative
// error of the integral below 1e-12 (fitting/hemi_epd_test.cpp compares with numerical
// integration). Precondition: kappa > 0, gamma > 0.
double LogHemisphereIntegral(const Lobe& lobe);

// log cos theta_h, kept finite at the horizon: what the lobes are functions of.
inline double LogCos(double theta_h) { return std::log(std::max(std::cos(theta_h), 1e-9)); }

// Above this a lobe has vanished: cos^gamma < exp(-40).
inline constexpr double kVanished = -40;

// exp(kappa cos^gamma theta_h) - 1 [1/sr]; log_cos = LogCos(theta_h).
inline double EvalLobe(const Lobe& lobe, double log_cos) {
  const double exponent = lobe.gamma * log_cos;
  return exponent > kVanished ? std::expm1(lobe.kappa * std::exp(exponent)) : 0;
}

// The same with its derivatives.
struct LobeSlopes {
  double f_r = 0;           // 1/sr
  double by_log_kappa = 0;  // d f_r / d log kappa
  double by_log_gamma = 0;  // d f_r / d log gamma
};
inline LobeSlopes EvalLobeWithSlopes(const Lobe& lobe, double log_cos) {
  const double exponent = lobe.gamma * log_cos;
  if (exponent <= kVanished) return {};
  const double x = lobe.kappa * std::exp(exponent);  // kappa cos^gamma
  const double rise = std::expm1(x);
  const double slope = (rise + 1) * x;
  return {rise, slope, slope * exponent};
}

// A lobe by the logarithms of its parameters, held within bounds far outside what materials show,
// so that no step of an optimiser overflows: what fits iterate on.
class BoundedLobe {
 public:
  static constexpr double kMinLogKappa = -14;
  static constexpr double kMaxLogKappa = 2.77;  // kappa = 16: 9e6 / sr high
  static constexpr double kMinLogGamma = -4.6;  // 0.01: constant to 89.9 degrees
  static constexpr double kMaxLogGamma = 10.8;  // 50,000: half a degree wide

  BoundedLobe() = default;
  BoundedLobe(double log_kappa, double log_gamma)
      : lobe_{std::exp(std::clamp(log_kappa, kMinLogKappa, kMaxLogKappa)),
              std::exp(std::clamp(log_gamma, kMinLogGamma, kMaxLogGamma))},
        kappa_held_(log_kappa < kMinLogKappa || log_kappa > kMaxLogKappa),
        gamma_held_(log_gamma < kMinLogGamma || log_gamma > kMaxLogGamma) {}

  static Eigen::Vector2d Clamp(const Eigen::Vector2d& logs) {
    return {std::clamp(logs[0], kMinLogKappa, kMaxLogKappa),
            std::clamp(logs[1], kMinLogGamma, kMaxLogGamma)};
  }

  const Lobe& lobe() const { return lobe_; }
  // f_r, its slope by log kappa and by log gamma at many theta_h at once, a column each, as
  // Slopes() has them one by one; f_r to 1e-16 / sr, which is enough to fit by. Precondition:
  // log_cos descends, so that what has vanished is a tail.
  using Columns = Eigen::Array<double, Eigen::Dynamic, 3>;
  void Fill(const Eigen::ArrayXd& log_cos, Columns* columns) const;

  // A parameter beyond its bound has no slope.
  LobeSlopes Slopes(double log_cos) const {
    LobeSlopes slopes = EvalLobeWithSlopes(lobe_, log_cos);
    if (kappa_held_) slopes.by_log_kappa = 0;
    if (gamma_held_) slopes.by_log_gamma = 0;
    return slopes;
  }

 private:
  Lobe lobe_;
  bool kappa_held_ = false;
  bool gamma_held_ = false;
};

// log of EvalLobe, which needs no lobe to be above the smallest double: for comparing lobes that
// have all but vanished.
double LogLobe(const Lobe& lobe, double log_cos);

}  // namespace gonio
