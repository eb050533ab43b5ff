// SPDX-License-Identifier: Apache-2.0
// Random numbers that are the same on every machine: std::normal_distribution is not.

#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "core/units.h"
#include "sim/ziggurat.h"

namespace gonio {

class Random {
 public:
  // `stream` separates generators of one seed: each device has its own, so that reading one never
  // changes what another does.
  Random(std::uint64_t seed, std::uint64_t stream) : engine_(Hash(seed, stream)) {}

  // 64 bits that depend on nothing but these two numbers, for patterns that can be asked anywhere.
  static std::uint64_t Hash(std::uint64_t seed, std::uint64_t index) {
    return Scramble(seed + 0x9e3779b97f4a7c15u * (index + 1));
  }

  // In (0, 1).
  double Uniform() { return Uniform(engine_()); }
  static double Uniform(std::uint64_t bits) {
    return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
  }

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

  // As Normal() and Poisson(), several times as fast, and other numbers: for one draw per pixel.
  double QuickNormal() {
    for (;;) {
      const std::uint64_t bits = engine_();
      const int layer = static_cast<int>(bits & (Ziggurat::kLayers - 1));
      // In (-1, 1): the upper 54 bits and their sign.
      const double u = (static_cast<double>(static_cast<std::int64_t>(bits) >> 10) + 0.5) * 0x1p-53;
      const double x = u * table_->x[layer];
      if (std::abs(x) < table_->x[layer + 1]) return x;
      if (layer == 0) return std::copysign(Tail(), u);
      const double y = table_->y[layer] + Uniform() * (table_->y[layer + 1] - table_->y[layer]);
      if (y < std::exp(-x * x / 2)) return x;
    }
  }

  // Below 12 by inversion, which is exact. Above, the nearest integer to the Cornish-Fisher
  // expansion: mean, variance and skewness are Poisson's.
  double QuickPoisson(double mean) {
    if (mean <= 0) return 0;
    if (mean < 12) return Inverted(mean);
    // Of the variance, the square brings 2/36 and rounding brings 1/12.
    const double normal = QuickNormal();
    const double x = mean + std::sqrt(mean - 5.0 / 36) * normal + (normal * normal - 1) / 6;
    return x > 0 ? static_cast<double>(static_cast<std::int64_t>(x + 0.5)) : 0;
  }

 private:
  // Beyond the ziggurat's lowest edge (Marsaglia, "Generating a variable from the tail of the
  // normal distribution", 1964).
  double Tail() {
    for (;;) {
      const double x = -std::log(Uniform()) / Ziggurat::kTail;
      if (-2 * std::log(Uniform()) > x * x) return Ziggurat::kTail + x;
    }
  }

  double Inverted(double mean) {
    double left = Uniform();
    double probability = std::exp(-mean);
    int events = 0;
    while (left > probability && probability > 0) {
      left -= probability;
      probability *= mean / ++events;
    }
    return events;
  }

  // SplitMix64's finaliser (Steele, Lea and Flood, 2014): neighbouring seeds become unrelated.
  static std::uint64_t Scramble(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }

  std::mt19937_64 engine_;
  const Ziggurat* table_ = &Ziggurat::Instance();
};

}  // namespace gonio
