// SPDX-License-Identifier: Apache-2.0
// Frames of a sensor whose every property is known, and scores of what is recovered from them.

#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include "acquisition/radiometry/sensor.h"
#include "sim/random.h"

namespace gonio {

struct SyntheticSensor {
  SensorFormat format{.camera = "synthetic", .width = 32, .height = 32};
  double gain = 2;         // electrons/count
  double read_noise = 5;   // electrons
  double black = 64;       // counts
  double full_well = 1e9;  // electrons
  double bend = 0;         // counts read are counts (1 - bend counts / full_scale)
  double light_noise = 0;  // relative, one draw per frame and channel
  SiteImage response;      // per site, mean 1; empty: 1
  SiteImage dark_rate;     // electrons/s per site; empty: none
  SiteImage bias;          // counts per site on top of `black`; empty: none

  // `rate`: electrons/s of light 1 in each channel.
  Frame Expose(const std::array<double, 3>& rate, double exposure, double monitor,
               Random* random) const {
    Frame frame{.width = format.width,
                .height = format.height,
                .layout = format.layout,
                .counts = std::vector<std::uint16_t>(format.sites()),
                .exposure = Seconds(exposure),
                .gain_db = format.gain_db,
                .black_level = black,
                .temperature_c = 20};
    std::array<double, 3> light;
    for (int c = 0; c < 3; ++c) {
      const double draw = light_noise > 0 ? 1 + light_noise * random->Normal() : 1;
      light[c] = rate[c] * exposure * monitor * draw;
    }
    VisitSites(format, [&](std::size_t i, int c) {
      double mean = light[c] * (response.empty() ? 1 : response[i]);
      if (!dark_rate.empty()) mean += dark_rate[i] * exposure;
      const double held = std::min(random->Poisson(mean), full_well);
      double counts = (held + read_noise * random->Normal()) / gain;
      counts -= bend * counts * counts / format.full_scale;
      counts += black + (bias.empty() ? 0 : bias[i]);
      frame.counts[i] = static_cast<std::uint16_t>(
          std::clamp(std::round(counts), 0.0, static_cast<double>(format.full_scale)));
    });
    return frame;
  }
};

// Collects z = (found - true) / sigma.
class Scores {
 public:
  void Add(double z) {
    ++n_;
    sum_ += z;
    squares_ += z * z;
  }
  double mean() const { return sum_ / n_; }
  double deviation() const { return std::sqrt(squares_ / n_ - mean() * mean()); }
  // The mean is within four of its standard errors.
  double mean_limit() const { return 4 / std::sqrt(n_); }

 private:
  double n_ = 0;
  double sum_ = 0;
  double squares_ = 0;
};

// EXPECT_HONEST(scores): no bias, and errors as large as the sigmas say. Needs some 500 scores for
// the deviation to be known to 3 %.
#define EXPECT_HONEST(scores)                             \
  EXPECT_NEAR((scores).mean(), 0, (scores).mean_limit()); \
  EXPECT_NEAR((scores).deviation(), 1, 0.1)

}  // namespace gonio
