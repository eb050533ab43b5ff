// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/exposure_offset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "brdf/brdf.h"

namespace gonio {
namespace {

double Square(double x) { return x * x; }

// What the good sites of a channel have without light, on average.
struct MeanDark {
  double bias = 0;  // counts
  double rate = 0;  // counts/s
  double n = 0;
};

std::array<MeanDark, kChannels> MeansOf(const DarkFit& dark, const SensorFormat& format,
                                        const SiteMask& bad) {
  std::array<MeanDark, kChannels> means;
  VisitSites(format, [&](std::size_t i, int c) {
    if (!bad.empty() && bad[i] != 0) return;
    MeanDark& mean = means[static_cast<std::size_t>(c)];
    mean.bias += dark.bias[i];
    mean.rate += dark.rate[i];
    mean.n += 1;
  });
  for (MeanDark& mean : means) {
    mean.bias /= std::max(1.0, mean.n);
    mean.rate /= std::max(1.0, mean.n);
  }
  return means;
}

// Of the mean bias, counts: of read noise, and of the rounding that all sites have alike.
double BiasSigma(const DarkFit& dark, double sites) {
  double variance = 0;
  for (const DarkFit::Level& level : dark.levels) {
    variance += Square(level.to_bias) * dark.read_variance / level.frames / sites;
  }
  return std::sqrt(variance + SharedRounding(dark.read_variance));
}

// The line of one channel.
std::optional<LineFit> FitChannel(const std::vector<TransferPoint>& points, int channel,
                                  const MeanDark& dark, const ExposureOffsetOptions& options) {
  std::vector<double> t, y, noise;
  double slope = 0;  // of the brightest point
  double brightest = 0;
  for (const TransferPoint& p : points) {
    const double net = p.mean - dark.bias - dark.rate * p.exposure;
    if (p.channel != channel || p.clipped > 0 || net > options.max_counts) continue;
    t.push_back(p.exposure);
    y.push_back(net / p.monitor);
    noise.push_back(p.mean_sigma / p.monitor);
    if (net < brightest) continue;
    brightest = net;
    slope = net / p.monitor / p.exposure;
  }
  std::vector<double> sigmas;
  for (std::size_t i = 0; i < t.size(); ++i) {
    // Two frames, each with its own draw of the light; of the signal that is expected.
    sigmas.push_back(std::hypot(noise[i], options.light_noise / std::sqrt(2.0) * slope * t[i]));
    if (!(sigmas.back() > 0)) return std::nullopt;
  }
  return FitLine(t, y, sigmas);
}

}  // namespace

Result<ExposureOffset> MeasureExposureOffset(const std::vector<TransferPoint>& points,
                                             const DarkFit& dark, const SensorFormat& format,
                                             const ExposureOffsetOptions& options) {
  const auto darks = MeansOf(dark, format, options.bad);
  ExposureOffset result;
  std::vector<MeasuredValue> channels;
  for (int c = 0; c < ChannelsOf(format.layout); ++c) {
    const MeanDark& mean = darks[static_cast<std::size_t>(c)];
    const auto line = FitChannel(points, c, mean, options);
    if (!line) continue;
    const double slope = line->slope.value;
    if (!(slope > 5 * line->slope.sigma)) {
      return Error{ErrorCode::kRefused, "exposure offset: the counts do not grow with exposures"};
    }
    const double offset = line->intercept.value / slope;
    const double variance = Square(line->intercept.sigma) + Square(offset * line->slope.sigma) -
                            2 * offset * line->covariance +
                            Square(BiasSigma(dark, std::max(1.0, mean.n)));
    channels.push_back({offset, std::sqrt(variance) / slope});
    result.chi_squared += line->chi_squared;
    result.degrees_of_freedom += line->degrees_of_freedom;
  }
  if (channels.empty()) {
    return Error{ErrorCode::kRefused,
                 "exposure offset: no two different exposures that are dim enough"};
  }
  double weights = 0, weighted = 0;
  for (const MeasuredValue& channel : channels) {
    weights += 1 / Square(channel.sigma);
    weighted += channel.value / Square(channel.sigma);
  }
  result.offset = {weighted / weights, 1 / std::sqrt(weights)};
  return result;
}

}  // namespace gonio
