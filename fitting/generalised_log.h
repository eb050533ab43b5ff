// SPDX-License-Identifier: Apache-2.0
// The scale reflectance is fitted on.

#pragma once

#include <cmath>

namespace gonio {

// The generalised logarithm, log of f with a floor:
//
//   glog(f) = asinh(f / (2 floor)) + log(floor)  ->  log f  for f >> floor
//
// It is smooth through zero, so that dark and negative readings stay data, and it makes the
// variance of noise with an additive and a multiplicative part constant (Durbin et al.,
// Bioinformatics 18, 2002; Huber et al., ibid.). Its derivative is 1 / sqrt(f^2 + 4 floor^2).
inline double GeneralisedLog(double f_r, double floor) {
  return std::asinh(f_r / (2 * floor)) + std::log(floor);
}
inline double GeneralisedLogSlope(double f_r, double floor) {
  return 1 / std::sqrt(f_r * f_r + 4 * floor * floor);
}
// f_r whose generalised logarithm is `glog`.
inline double FromGeneralisedLog(double glog, double floor) {
  return 2 * floor * std::sinh(glog - std::log(floor));
}

}  // namespace gonio
