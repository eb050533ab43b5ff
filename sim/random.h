// SPDX-License-Identifier: Apache-2.0
// Random numbers that are the same on every machine: std::normal_distribution is not.

#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "core/units.h"

namespace gonio {

class Random {
 public:
  // `stream` separates generators of one seed: each device has its own, so that reading one never
  // changes what another does.
  Random(std::uint64_t seed, std::uint64_t stream)
      : engine_(Scramble(seed + 0x9e3779b97f4a7c15u * (stream + 1))) {}

  // In (0, 1).
  double Uniform() { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53; }

  // Standard normal (Box and Muller, 1958).
  double Normal() {
    const double radius = std::sqrt(-2 * std::log(Uniform()));
    return radius * std::cos(2 * kPi * Uniform());
  }

  // Poisson of this mean. Above 50 the normal distribution stands in: skewness is then below 0.15.
  double Poisson(double mean) {
    if (mean <= 0) return 0;
    if (mean > 50) return mean + std::sqrt(mean) * Normal();
    const double floor = std::exp(-mean);
    int events = 0;
    for (double product = Uniform(); product > floor; product *= Uniform()) ++events;
    return events;
  }

 private:
  // SplitMix64's finaliser (Steele, Lea and Flood, 2014): neighbouring seeds become unrelated.
  static std::uint64_t Scramble(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }

  std::mt19937_64 engine_;
};

}  // namespace gonio
