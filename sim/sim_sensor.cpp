// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_sensor.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace gonio {
SimSensor::SimSensor(const SimConfig& truth, int width, int height, Random random, bool quick)
    : truth_(truth), width_(width), height_(height), quick_(quick), random_(random) {
  const bool alike = truth.prnu <= 0 && truth.dsnu <= 0 && truth.hot_pixels <= 0 &&
                     (truth.dark_spread <= 0 || truth.dark_current <= 0);
  if (alike) return;
  fixed_.reserve(static_cast<std::size_t>(width) * height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) fixed_.push_back(FixedOf(x, y));
  }
}

SimSensor::Fixed SimSensor::FixedOf(int x, int y) const {
  const std::uint64_t place = (static_cast<std::uint64_t>(y) << 32) | static_cast<unsigned>(x);
  const std::uint64_t pixel = Random::Hash(truth_.sensor_seed, place);
  const auto uniform = [&](int i) { return Random::Uniform(Random::Hash(pixel, i)); };
  // Box and Muller, both of a pair and one of a second.
  const double radius = std::sqrt(-2 * std::log(uniform(0)));
  const double prnu = radius * std::cos(2 * kPi * uniform(1));
  const double dsnu = radius * std::sin(2 * kPi * uniform(1));
  const double spread = std::sqrt(-2 * std::log(uniform(2))) * std::cos(2 * kPi * uniform(3));
  double dark = truth_.dark_current * std::max(-1.0, truth_.dark_spread * spread);
  if (uniform(4) < truth_.hot_pixels) dark += truth_.hot_dark_current;
  return {.gain = static_cast<float>(std::max(0.0, 1 + truth_.prnu * prnu)),
          .dark_rate = static_cast<float>(dark),
          .offset = static_cast<float>(truth_.dsnu * dsnu)};
}

SimReadout SimSensor::Whole(SimReadout readout) const {
  if (readout.region.width == 0) readout.region = {0, 0, width_, height_};
  return readout;
}

SimSensor::Scale SimSensor::ScaleFor(const SimReadout& readout) {
  Scale scale;
  for (double& light : scale.light) {
    light = std::max(0.0, 1 + truth_.multiplicative_noise * random_.Normal());
  }
  scale.dark_per_rate = readout.exposure.count();
  if (truth_.dark_doubling > 0 && readout.temperature_c) {
    scale.dark_per_rate *=
        std::exp2((*readout.temperature_c - truth_.reference_c) / truth_.dark_doubling);
  }
  scale.dark = truth_.dark_current * scale.dark_per_rate;
  scale.electrons_per_count = truth_.electrons_per_count * std::pow(10, -readout.gain_db / 20);
  scale.black_level = readout.black_level;
  scale.full_scale = readout.full_scale;
  const double full = (readout.full_scale - readout.black_level) * scale.electrons_per_count;
  scale.bend = truth_.nonlinearity / full;
  scale.peak = scale.bend > 0 ? 1 / (2 * scale.bend) : 0;
  return scale;
}

template <bool kQuick>
std::uint16_t SimSensor::Count(double light, const Fixed& fixed, const Scale& scale) {
  const double mean = light * fixed.gain + (scale.dark + fixed.dark_rate * scale.dark_per_rate);
  double electrons = mean;
  if (truth_.shot_noise) electrons = kQuick ? random_.QuickPoisson(mean) : random_.Poisson(mean);
  if (truth_.full_well > 0) electrons = std::min(electrons, truth_.full_well);
  if (scale.bend > 0) electrons = std::min(electrons, scale.peak);
  electrons -= scale.bend * electrons * electrons;
  electrons += fixed.offset;
  if (truth_.read_noise > 0) {
    electrons += truth_.read_noise * (kQuick ? random_.QuickNormal() : random_.Normal());
  }
  const double count = electrons / scale.electrons_per_count + scale.black_level;
  if (!(count > 0)) return 0;
  if (count >= scale.full_scale) return static_cast<std::uint16_t>(scale.full_scale);
  return static_cast<std::uint16_t>(count + 0.5);
}

template <bool kQuick>
void SimSensor::Fill(const SimImage& electrons, const SimReadout& readout, const Scale& scale,
                     std::vector<std::uint16_t>& counts) {
  const auto [x0, y0, width, height] = readout.region;
  const std::size_t pixels = static_cast<std::size_t>(width) * height;
  const int per_pixel = CountsPerPixel(readout.layout);
  const bool mono = readout.layout == PixelLayout::kMono;
  const bool bayer = per_pixel == 1 && !mono;
  std::array<double, kChannels> uniform{};
  for (int c = 0; c < kChannels; ++c) {
    uniform[c] = (mono ? electrons.uniform.mean() : electrons.uniform[c]) * scale.light[c];
  }
  std::size_t next = 0;
  for (int y = 0; y < height; ++y) {
    // Colours of the even and the odd columns.
    const std::array<int, 2> colours = {bayer ? BayerChannel(readout.layout, 0, y) : 0,
                                        bayer ? BayerChannel(readout.layout, 1, y) : 0};
    const Fixed* fixed =
        fixed_.empty() ? nullptr : &fixed_[static_cast<std::size_t>(y0 + y) * width_ + x0];
    const float* row = electrons.values.data() + static_cast<std::size_t>(y) * width;
    for (int x = 0; x < width; ++x) {
      for (int k = 0; k < per_pixel; ++k) {
        const int c = per_pixel > 1 ? k : colours[x & 1];
        const double light =
            electrons.planes == 0 ? uniform[c] : row[c * pixels + x] * scale.light[c];
        counts[next++] = Count<kQuick>(light, fixed != nullptr ? fixed[x] : Fixed{}, scale);
      }
    }
  }
}

Frame SimSensor::Read(const SimImage& electrons, const SimReadout& given) {
  const SimReadout readout = Whole(given);
  const SimRegion& region = readout.region;
  GONIO_CHECK(region.x >= 0 && region.y >= 0 && region.x + region.width <= width_ &&
                  region.y + region.height <= height_,
              "a region beyond the sensor");
  GONIO_CHECK(electrons.width == region.width && electrons.height == region.height,
              "the image of another region");
  Frame frame;
  frame.width = region.width;
  frame.height = region.height;
  frame.layout = readout.layout;
  frame.exposure = readout.exposure;
  frame.gain_db = readout.gain_db;
  frame.black_level = readout.black_level;
  frame.temperature_c = readout.temperature_c;
  frame.counts.resize(static_cast<std::size_t>(region.width) * region.height *
                      CountsPerPixel(readout.layout));
  const Scale scale = ScaleFor(readout);
  quick_ ? Fill<true>(electrons, readout, scale, frame.counts)
         : Fill<false>(electrons, readout, scale, frame.counts);
  return frame;
}

}  // namespace gonio
