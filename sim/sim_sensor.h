// SPDX-License-Identifier: Apache-2.0
// Electrons become counts.

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/camera.h"
#include "sim/random.h"
#include "sim/sim_config.h"
#include "sim/sim_optics.h"

namespace gonio {

// How a sensor is exposed and read out.
struct SimReadout {
  Seconds exposure{0};
  double gain_db = 0;      // electrons_per_count is divided by 10^(gain_db / 20)
  double black_level = 0;  // counts
  std::optional<double> temperature_c = std::nullopt;  // unknown: as at SimConfig::reference_c
  SimRegion region{};                                  // width 0: the whole sensor
  PixelLayout layout = PixelLayout::kRgb;              // of the region as it is read out
  int full_scale = 4095;                               // counts
};

// A sensor of width by height pixels:
//
//   light     = electrons(pixel, channel) (1 + m) (1 + prnu)
//   dark      = (dark_current (1 + spread) + hot) 2^((T - reference_c) / dark_doubling) t
//   electrons = min(Poisson(light + dark), full_well)
//   linear    = electrons (1 - nonlinearity electrons / the electrons of full scale)
//   counts    = round((linear + dsnu + read noise) / K + black level), clipped to 0 .. full scale
//
// m is drawn once per frame and channel (the first channel's is that of a monochrome frame); prnu,
// spread, hot and dsnu are the pixel's own, of (sensor_seed, column, row) and nothing else: regions
// agree, and so do sessions. A pixel of three counts has them once.
class SimSensor {
 public:
  // `random`: the temporal noise. `quick`: by Random's quick generators.
  SimSensor(const SimConfig& truth, int width, int height, Random random, bool quick);

  // `electrons` of the light that came during the exposure, in the readout's region. Precondition:
  // the region lies on the sensor and is the image's. Frame::start is left to the caller.
  Frame Read(const SimImage& electrons, const SimReadout& readout);

  // The temporal noise comes from `random` from now on.
  void Reseed(Random random) { random_ = random; }

  // The readout with its region filled in.
  SimReadout Whole(SimReadout readout) const;

 private:
  // What does not change from pixel to pixel, so that the loop over them has only numbers.
  struct Scale {
    std::array<double, kChannels> light{};  // 1 + m
    double dark = 0;                        // electrons of a pixel of average dark current
    double dark_per_rate = 0;               // s at reference_c that give as many
    double electrons_per_count = 1;
    double bend = 0;  // nonlinearity over the electrons of full scale
    double peak = 0;  // electrons at which the bent curve would turn down
    double black_level = 0;
    double full_scale = 0;
  };
  // Of one pixel.
  struct Fixed {
    float gain = 1;       // 1 + prnu
    float dark_rate = 0;  // electrons/s more than the average
    float offset = 0;     // electrons
  };

  Scale ScaleFor(const SimReadout& readout);
  Fixed FixedOf(int x, int y) const;
  template <bool kQuick>
  void Fill(const SimImage& electrons, const SimReadout& readout, const Scale& scale,
            std::vector<std::uint16_t>& counts);
  template <bool kQuick>
  std::uint16_t Count(double light, const Fixed& fixed, const Scale& scale);

  const SimConfig truth_;
  const int width_;
  const int height_;
  const bool quick_;
  Random random_;
  std::vector<Fixed> fixed_;  // empty: the pixels are alike
};

}  // namespace gonio
