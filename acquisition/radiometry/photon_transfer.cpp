// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/photon_transfer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "brdf/brdf.h"
#include "core/check.h"

namespace gonio {
namespace {

constexpr std::size_t kMinSites = 100;
constexpr double kRounding = 1.0 / 12;      // counts^2
constexpr double kHiddenVariance = 0.24;    // counts^2, EMVA 1288
constexpr double kHiddenNoise = 0.4;        // counts, EMVA 1288
constexpr double kCollapsedVariance = 0.5;  // of what the line says: the sites are full
constexpr double kNoClipping = 1e-3;        // fraction of clipped sites that a point may have

double Square(double x) { return x * x; }

// Sums over the sites of one channel.
struct Sums {
  std::size_t sites = 0;
  std::size_t clipped = 0;
  double first = 0;
  double second = 0;
};

std::array<Sums, kChannels> SumsOf(const SensorFormat& format, const FlatPair& pair,
                                   const SiteMask& bad) {
  std::array<Sums, kChannels> sums;
  VisitSites(format, [&](std::size_t i, int c) {
    if (!bad.empty() && bad[i] != 0) return;
    const int a = pair.first.counts[i];
    const int b = pair.second.counts[i];
    Sums& sum = sums[static_cast<std::size_t>(c)];
    ++sum.sites;
    sum.clipped += std::max(a, b) >= format.full_scale;
    sum.first += a - pair.first.black_level;
    sum.second += b - pair.second.black_level;
  });
  return sums;
}

// Variance and fourth moment of the scaled difference of a pair, over one channel.
struct Moments {
  double second = 0;
  double fourth = 0;
};

std::array<Moments, kChannels> MomentsOf(const SensorFormat& format, const FlatPair& pair,
                                         const SiteMask& bad,
                                         const std::array<Sums, kChannels>& sums) {
  // Both frames are brought to their geometric mean, which changes the sum of their variances only
  // by the square of their difference. In the dark there is no pattern to scale.
  std::array<double, kChannels> scale;
  std::array<double, kChannels> offset;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const double ratio = sums[c].second > 0 ? sums[c].first / sums[c].second : 1;
    scale[c] = std::abs(ratio - 1) < 0.2 ? std::sqrt(ratio) : 1;
    const double n = std::max<double>(1, static_cast<double>(sums[c].sites));
    offset[c] = (sums[c].first / scale[c] - sums[c].second * scale[c]) / n;
  }
  std::array<Moments, kChannels> moments;
  VisitSites(format, [&](std::size_t i, int channel) {
    if (!bad.empty() && bad[i] != 0) return;
    const auto c = static_cast<std::size_t>(channel);
    const double d = (pair.first.counts[i] - pair.first.black_level) / scale[c] -
                     (pair.second.counts[i] - pair.second.black_level) * scale[c] - offset[c];
    moments[c].second += d * d;
    moments[c].fourth += d * d * d * d;
  });
  return moments;
}

std::string ComplaintAbout(const SensorFormat& format, const FlatPair& pair, const SiteMask& bad) {
  for (const Frame* frame : {&pair.first, &pair.second}) {
    const std::string difference = DifferenceOf(format, *frame);
    if (!difference.empty()) return difference;
  }
  if (!bad.empty() && bad.size() != format.sites()) return "the mask is of another size";
  if (pair.first.exposure != pair.second.exposure) return "the exposures of a pair differ";
  return "";
}

TransferPoint PointOf(const FlatPair& pair, int channel, const Sums& sums, const Moments& moments) {
  const auto n = static_cast<double>(sums.sites);
  TransferPoint point;
  point.channel = channel;
  point.exposure = pair.first.exposure.count();
  point.monitor = (pair.monitor_first + pair.monitor_second) / 2;
  point.mean = (sums.first + sums.second) / (2 * n);
  point.variance = moments.second / (2 * (n - 1));
  point.mean_sigma = std::sqrt(point.variance / (2 * n));
  const double second = moments.second / n;
  point.variance_sigma = std::sqrt(std::max(0.0, moments.fourth / n - Square(second)) / n) / 2;
  point.clipped = static_cast<double>(sums.clipped) / n;
  return point;
}

// The line, fitted twice: the first time with the scatter as it is, then with the scatter that the
// line predicts, as a variance that came out low would also claim a small sigma.
std::optional<LineFit> FitTransfer(const std::vector<TransferPoint>& points) {
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> relative;
  for (const TransferPoint& p : points) {
    if (!p.used) continue;
    x.push_back(p.mean);
    y.push_back(p.variance);
    relative.push_back(p.variance_sigma / p.variance);
  }
  std::vector<double> sigmas;
  for (std::size_t i = 0; i < x.size(); ++i) sigmas.push_back(relative[i] * y[i]);
  std::optional<LineFit> fit = FitLine(x, y, sigmas);
  for (int round = 0; fit && round < 3; ++round) {
    for (std::size_t i = 0, k = 0; k < points.size(); ++k) {
      if (!points[k].used) continue;
      const double expected = fit->intercept.value + fit->slope.value * x[i];
      const double along = fit->slope.value * points[k].mean_sigma;
      sigmas[i] = std::hypot(relative[i] * (expected > 0 ? expected : y[i]), along);
      ++i;
    }
    fit = FitLine(x, y, sigmas);
  }
  return fit;
}

void SetReadNoise(const LineFit& fit, PhotonTransfer* transfer) {
  const double gain = transfer->gain.value;
  if (fit.intercept.value < kHiddenVariance) {
    transfer->read_noise_hidden = true;
    transfer->read_noise = {kHiddenNoise * gain, kHiddenNoise * gain / std::sqrt(3.0)};
    return;
  }
  // r = sqrt(a - 1/12) / b for the line a + b m.
  const double a = fit.intercept.value - kRounding;
  const double b = fit.slope.value;
  const double by_a = 0.5 / (std::sqrt(a) * b);
  const double by_b = -std::sqrt(a) / Square(b);
  transfer->read_noise.value = std::sqrt(a) / b;
  transfer->read_noise.sigma =
      std::sqrt(Square(by_a * fit.intercept.sigma) + Square(by_b * fit.slope.sigma) +
                2 * by_a * by_b * fit.covariance);
}

// Variance over the sites of their mean in a pair: how much they differ.
double SpreadOfSites(const SensorFormat& format, const FlatPair& pair, const TransferPoint& point,
                     const SiteMask& bad) {
  double sum = 0;
  double n = 0;
  VisitSites(format, [&](std::size_t i, int c) {
    if (c != point.channel || (!bad.empty() && bad[i] != 0)) return;
    const double mean = (pair.first.counts[i] - pair.first.black_level + pair.second.counts[i] -
                         pair.second.black_level) /
                        2;
    sum += Square(mean - point.mean);
    n += 1;
  });
  return std::max(0.0, sum / (n - 1) - point.variance / 2);
}

void SetFullWell(const SensorFormat& format, const std::vector<FlatPair>& pairs,
                 const SiteMask& bad, const LineFit& fit, PhotonTransfer* transfer) {
  const auto brightest =
      std::max_element(transfer->points.begin(), transfer->points.end(),
                       [](const auto& a, const auto& b) { return a.mean < b.mean; });
  const auto index = static_cast<std::size_t>(brightest - transfer->points.begin());
  const FlatPair& pair = pairs[index / static_cast<std::size_t>(ChannelsOf(format.layout))];
  const double expected = fit.intercept.value + fit.slope.value * brightest->mean;
  const double spread = std::sqrt(SpreadOfSites(format, pair, *brightest, bad));
  transfer->full_well_reached = brightest->variance < kCollapsedVariance * expected;
  transfer->full_well_is_full_scale = brightest->clipped > 0.5;
  transfer->full_well.value = transfer->gain.value * brightest->mean;
  transfer->full_well.sigma =
      std::hypot(transfer->gain.sigma * brightest->mean, transfer->gain.value * spread);
}

Error Refusal(const std::string& why) { return {ErrorCode::kRefused, "photon transfer: " + why}; }

}  // namespace

Result<std::vector<TransferPoint>> TransferPoints(const SensorFormat& format,
                                                  const std::vector<FlatPair>& pairs,
                                                  const TransferOptions& options) {
  std::vector<TransferPoint> points;
  for (const FlatPair& pair : pairs) {
    const std::string complaint = ComplaintAbout(format, pair, options.bad);
    if (!complaint.empty()) return Refusal(complaint);
    const auto sums = SumsOf(format, pair, options.bad);
    const auto moments = MomentsOf(format, pair, options.bad, sums);
    const double limit = options.max_fraction * (format.full_scale - pair.first.black_level);
    for (int c = 0; c < ChannelsOf(format.layout); ++c) {
      const auto k = static_cast<std::size_t>(c);
      if (sums[k].sites < kMinSites) {
        return Refusal(fmt::format("{} good sites, needs {}", sums[k].sites, kMinSites));
      }
      points.push_back(PointOf(pair, c, sums[k], moments[k]));
      TransferPoint& point = points.back();
      // A pair without any noise says nothing about noise.
      point.used = point.mean <= limit && point.clipped <= kNoClipping && point.variance_sigma > 0;
    }
  }
  return points;
}

Result<PhotonTransfer> MeasurePhotonTransfer(const SensorFormat& format,
                                             const std::vector<FlatPair>& pairs,
                                             const TransferOptions& options) {
  auto points = TransferPoints(format, pairs, options);
  if (!points) return points.error();
  PhotonTransfer transfer;
  transfer.points = std::move(points).value();
  const auto used = std::count_if(transfer.points.begin(), transfer.points.end(),
                                  [](const TransferPoint& p) { return p.used; });
  if (used < 3) return Refusal(fmt::format("{} points below saturation, needs 3", used));
  const auto fit = FitTransfer(transfer.points);
  if (!fit) return Refusal("all pairs are equally bright");
  if (!(fit->slope.value > 5 * fit->slope.sigma)) {
    return Refusal("the variance does not grow with the mean");
  }
  transfer.gain = {1 / fit->slope.value, fit->slope.sigma / Square(fit->slope.value)};
  transfer.chi_squared = fit->chi_squared;
  transfer.degrees_of_freedom = fit->degrees_of_freedom;
  SetReadNoise(*fit, &transfer);
  SetFullWell(format, pairs, options.bad, *fit, &transfer);
  return transfer;
}

Result<std::vector<ExposureRatio>> ExposureRatios(const std::vector<TransferPoint>& points,
                                                  int channel, double reference,
                                                  double light_noise) {
  struct Mean {
    double weighted = 0;
    double weights = 0;
  };
  std::map<double, Mean> rates;  // counts per second of light 1, by exposure
  for (const TransferPoint& p : points) {
    if (p.channel != channel || p.clipped > kNoClipping || !(p.mean > 0)) continue;
    const double rate = p.mean / (p.exposure * p.monitor);
    // Two frames, each with its own draw of the light.
    const double relative = std::hypot(p.mean_sigma / p.mean, light_noise / std::sqrt(2.0));
    const double weight = 1 / Square(std::max(relative, 1e-12));
    rates[p.exposure].weighted += weight * rate;
    rates[p.exposure].weights += weight;
  }
  const auto found = rates.find(reference);
  if (found == rates.end()) {
    return Refusal(fmt::format("no pair of {} s to compare other exposures with", reference));
  }
  const double base = found->second.weighted / found->second.weights;
  const double base_variance = 1 / found->second.weights;
  std::vector<ExposureRatio> ratios;
  for (const auto& [exposure, mean] : rates) {
    const double ratio = mean.weighted / mean.weights / base;
    const double relative = exposure == reference ? 0 : 1 / mean.weights + base_variance;
    ratios.push_back({exposure, {ratio, ratio * std::sqrt(relative)}});
  }
  return ratios;
}

}  // namespace gonio
