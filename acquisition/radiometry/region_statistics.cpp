// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/region_statistics.h"

#include <cmath>
#include <limits>
#include <vector>

#include "acquisition/radiometry/measured_value.h"
#include "core/check.h"

namespace gonio {
namespace {

struct Site {
  float ratio;  // x_p / l_p
  float light;
  float variance;  // of x_p
  float shared;
};

struct Gathered {
  std::vector<Site> sites;
  int saturated = 0;
  int bad = 0;
};

void Gather(const MergedImage& image, std::size_t site, float light, Gathered* gathered) {
  const std::uint8_t state = image.state[site];
  if ((state & kAllSaturated) != 0) {
    ++gathered->saturated;
  } else if ((state & kAllBad) != 0 || !(light > 0)) {
    ++gathered->bad;
  } else {
    gathered->sites.push_back(
        {image.rate[site] / light, light, image.variance[site], image.shared[site]});
  }
}

ChannelStatistics Summarise(const Gathered& gathered, double outlier) {
  ChannelStatistics result;
  result.saturated = gathered.saturated;
  result.bad = gathered.bad;
  std::vector<float> ratios;
  for (const Site& site : gathered.sites) ratios.push_back(site.ratio);
  const RobustSpread spread = RobustSpreadOf(ratios);
  // Without any spread (a noiseless image) nothing is an outlier.
  const bool all = outlier <= 0 || !(spread.sigma > 0);
  double signal = 0, light = 0, variance = 0, shared = 0, squares = 0, noise = 0;
  for (const Site& site : gathered.sites) {
    if (!all && std::abs(site.ratio - spread.median) > outlier * spread.sigma) {
      ++result.outliers;
      continue;
    }
    ++result.used;
    signal += double{site.ratio} * site.light;
    light += site.light;
    variance += site.variance;
    shared += site.light * std::sqrt(double{site.shared});
    const double off = site.ratio - spread.median;
    squares += off * off;
    noise += site.variance / (double{site.light} * site.light);
  }
  if (result.used == 0) return result;
  const double n = result.used;
  result.mean = signal / light;
  result.light = light / n;
  result.variance = variance / (light * light);
  // Sites that use different frames share less than this.
  result.shared = (shared / light) * (shared / light);
  const double off = result.mean - spread.median;
  const double scatter = n > 1 ? std::max(0.0, squares - n * off * off) / (n - 1) : 0;
  result.spread = std::sqrt(scatter);
  if (result.mean != 0) {
    result.unevenness = std::sqrt(std::max(0.0, scatter - noise / n)) / std::abs(result.mean);
  }
  return result;
}

}  // namespace

double ChannelStatistics::sigma() const {
  if (used == 0) return std::numeric_limits<double>::infinity();
  return std::sqrt(variance + shared * mean * mean);
}

std::array<ChannelStatistics, kChannels> StatisticsOf(const MergedImage& image,
                                                      std::span<const std::uint32_t> pixels,
                                                      std::span<const float> lights,
                                                      double outlier) {
  GONIO_CHECK(lights.empty() || lights.size() == pixels.size(), "one light for each pixel");
  const PixelLayout layout = image.format.layout;
  const auto width = static_cast<std::uint32_t>(image.format.width);
  std::array<Gathered, kChannels> gathered;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::uint32_t pixel = pixels[i];
    const float light = lights.empty() ? 1.0F : lights[i];
    if (layout == PixelLayout::kRgb) {
      for (std::size_t c = 0; c < kChannels; ++c) {
        Gather(image, std::size_t{pixel} * kChannels + c, light, &gathered[c]);
      }
    } else {
      const int channel = layout == PixelLayout::kMono
                              ? 0
                              : BayerChannel(layout, static_cast<int>(pixel % width),
                                             static_cast<int>(pixel / width));
      Gather(image, pixel, light, &gathered[static_cast<std::size_t>(channel)]);
    }
  }
  std::array<ChannelStatistics, kChannels> result;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const bool copy = layout == PixelLayout::kMono && c > 0;
    result[c] = copy ? result[0] : Summarise(gathered[c], outlier);
  }
  return result;
}

}  // namespace gonio
