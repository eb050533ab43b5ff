// SPDX-License-Identifier: Apache-2.0
// Materials inside the DSBRDF family, and noisy readings of any material.

#pragma once

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "brdf/brdf.h"
#include "core/units.h"
#include "fitting/dsbrdf.h"
#include "fitting/spline.h"
#include "sim/random.h"

namespace gonio {

// Lobes from a diffuse one (kappa about 0.1, gamma about 0.5) to a peak (kappa about 1, gamma about
// 200), all different for each seed and a little different for each channel, smooth over theta_d.
inline Dsbrdf SyntheticMaterial(std::uint64_t seed, const DsbrdfShape& shape = {}) {
  Random random(seed, 0);
  Eigen::VectorXd parameters(shape.size());
  for (int k = 0; k < shape.lobes; ++k) {
    const double position = shape.lobes == 1 ? 0.5 : k / (shape.lobes - 1.0);
    const double means[2] = {std::log(0.1) + position * std::log(10.0),
                             std::log(0.5) + position * std::log(400.0)};
    for (int q = 0; q < 2; ++q) {
      const double level = means[q] + 0.5 * random.Normal();
      const double slope = 0.4 * random.Normal();
      for (int c = 0; c < kChannels; ++c) {
        const double shift = (q == 0 ? 0.4 : 0.1) * random.Normal();
        for (int j = 0; j < shape.knots; ++j) {
          parameters[shape.Index(c, k, q) + j] =
              level + shift + slope * std::sin(1.5 * KnotPosition(j, shape.knots));
        }
      }
    }
  }
  return Dsbrdf(shape, parameters, "synthetic");
}

// A direction pair with both polar angles below 85 deg; denser towards theta_h = 0.
inline DirectionPair RandomPose(Random& random) {
  for (;;) {
    const double u = random.Uniform();
    const double turn = 2 * kPi * random.Uniform();
    DirectionPair pair =
        ToDirections({u * u * kPi / 2, random.Uniform() * RadFromDeg(80), random.Uniform() * kPi});
    if (pair.wi.z() < std::cos(RadFromDeg(85)) || pair.wo.z() < std::cos(RadFromDeg(85))) continue;
    for (Eigen::Vector3d* w : {&pair.wi, &pair.wo}) {
      *w = Eigen::Vector3d(std::cos(turn) * w->x() - std::sin(turn) * w->y(),
                           std::sin(turn) * w->x() + std::cos(turn) * w->y(), w->z());
    }
    return pair;
  }
}

// A reading with Gaussian noise of standard deviation `relative_noise` f_r + 1e-4 / sr.
inline BrdfSample ReadingAt(const Brdf& material, const DirectionPair& pair, double relative_noise,
                            Random& random) {
  const Rgb f_r = *material.Eval(pair);
  BrdfSample sample{.directions = pair, .f_r = f_r, .sigma = relative_noise * f_r + 1e-4};
  if (relative_noise > 0) {
    for (int c = 0; c < kChannels; ++c) sample.f_r[c] += sample.sigma[c] * random.Normal();
  }
  return sample;
}

// `relative_noise` = 0: exact readings.
inline std::vector<BrdfSample> Readings(const Brdf& material, int poses, double relative_noise,
                                        std::uint64_t seed) {
  Random random(seed, 1);
  std::vector<BrdfSample> samples;
  samples.reserve(static_cast<std::size_t>(poses));
  for (int n = 0; n < poses; ++n) {
    samples.push_back(ReadingAt(material, RandomPose(random), relative_noise, random));
  }
  return samples;
}

}  // namespace gonio
