// SPDX-License-Identifier: Apache-2.0
// The normal distribution cut into layers, for generators that draw one number per pixel.

#pragma once

#include <array>
#include <cmath>

namespace gonio {

// The ziggurat of G. Marsaglia and W. W. Tsang, "The Ziggurat Method for Generating Random
// Variables", J. Stat. Software 5(8), 2000: kLayers rectangles of equal area cover exp(-x^2/2), x
// >= 0; the lowest one includes the tail. Exact; layer and abscissa come from different bits, which
// the original got wrong (J. A. Doornik, "An Improved Ziggurat Method to Generate Normal Random
// Samples", 2005).
struct Ziggurat {
  static constexpr int kLayers = 256;
  // Where the tail begins, which makes the topmost rectangle end at the curve's maximum.
  static constexpr double kTail = 3.6541528853610088;

  // Of layer i: the outer edge x[i], and the curve there, y[i] = exp(-x[i]^2 / 2). x[0] is the
  // width of the lowest rectangle if it had no tail; x[kLayers] = 0.
  std::array<double, kLayers + 1> x{};
  std::array<double, kLayers + 1> y{};

  Ziggurat() {
    const double below = std::exp(-kTail * kTail / 2);
    const double tail = std::sqrt(std::acos(-1.0) / 2) * std::erfc(kTail / std::sqrt(2.0));
    const double area = kTail * below + tail;
    x[0] = area / below;
    x[1] = kTail;
    for (int i = 1; i < kLayers - 1; ++i) {
      const double height = std::exp(-x[i] * x[i] / 2) + area / x[i];
      x[i + 1] = std::sqrt(-2 * std::log(height));
    }
    for (int i = 0; i <= kLayers; ++i) y[i] = std::exp(-x[i] * x[i] / 2);
  }

  static const Ziggurat& Instance() {
    static const Ziggurat instance;
    return instance;
  }
};

}  // namespace gonio
