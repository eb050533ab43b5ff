// SPDX-License-Identifier: Apache-2.0
// What every source of reflectance offers, and one measured sample of it.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "brdf/direction.h"

namespace gonio {

// One number per colour channel, in the order red, green, blue.
using Rgb = Eigen::Array3d;
inline constexpr int kChannels = 3;
inline constexpr const char* kChannelNames[kChannels] = {"red", "green", "blue"};

// A bidirectional reflectance distribution function of an isotropic sample: a table, an analytic
// material or a fit. Immutable once built; safe to read from several threads.
class Brdf {
 public:
  virtual ~Brdf() = default;

  // f_r [1/sr] (Nicodemus et al. 1977: radiance out over irradiance in), *without* the cosine.
  // Empty where nothing is known: below the horizon, invalid table cells, outside the domain.
  // Reciprocal, and the same for pairs that differ by a rotation about the normal.
  virtual std::optional<Rgb> Eval(const HalfDiff& angles) const = 0;

  std::optional<Rgb> Eval(const DirectionPair& pair) const {
    if (!pair.above_horizon()) return std::nullopt;
    return Eval(ToHalfDiff(pair));
  }

  // For titles and logs: a file name, a material's name.
  virtual std::string name() const = 0;
};

// One measured reflectance.
struct BrdfSample {
  DirectionPair directions;  // as read back from the encoders, never the set-point
  Rgb f_r = Rgb::Zero();     // 1/sr, no cosine; noise can make it negative, and that is kept
  // Standard uncertainty of f_r, 1/sr, > 0. Infinite: this channel could not be measured.
  Rgb sigma = Rgb::Zero();
};

}  // namespace gonio
