// SPDX-License-Identifier: Apache-2.0
#include "acquisition/bracket_check.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "acquisition/light_colours.h"
#include "acquisition/region_rates.h"

namespace gonio {
namespace {

double Square(double x) { return x * x; }

// One frame, corrected, with the noise that all its sites share left aside.
struct View {
  CorrectedFrame frame;
  double told = 0;  // s
  std::optional<LightColour> colour;
};

// Sums over the sites that two frames both show.
struct Common {
  double n = 0, first = 0, second = 0;  // electrons
};

std::array<Common, kChannels> CommonOf(const PoseRecord& pose, const CorrectedFrame& a,
                                       const CorrectedFrame& b) {
  std::array<Common, kChannels> sums;
  for (const ImageRegion& region : pose.regions) {
    for (int c = 0; c < kChannels; ++c) {
      Common& sum = sums[static_cast<std::size_t>(c)];
      for (const std::uint32_t site : SitesOf(a.format, region, c)) {
        if ((a.unusable[site] | b.unusable[site]) != 0) continue;
        sum.n += 1;
        sum.first += a.electrons[site];
        sum.second += b.electrons[site];
      }
    }
  }
  return sums;
}

// Relative variance of a frame's mean over n sites, if it has so many electrons a site.
double RelativeVariance(const CorrectedFrame& frame, double electrons, double n,
                        const RadiometryConfig& r) {
  const double noise = (electrons + frame.floor) / n / Square(electrons);
  return noise + Square(r.multiplicative_noise) + Square(r.monitor_noise);
}

// Two frames in one channel. Empty: they share no sites, or the shorter one is so faint that its
// dark matters more than its exposure.
std::optional<BracketMismatch> Compare(const View& shorter, const View& longer, const Common& sum,
                                       const RadiometryConfig& r, double offset_sigma) {
  constexpr double kLeastSignal = 10;  // times the noise of the mean
  if (sum.n == 0 || !(sum.second > 0)) return std::nullopt;
  const double bright = sum.second / sum.n;
  const double expected = bright * shorter.frame.gain() / longer.frame.gain();
  const double floor = std::sqrt((expected + shorter.frame.floor) / sum.n);
  if (!(expected > kLeastSignal * floor)) return std::nullopt;
  // What the shorter one is, over what the longer one says: so noise stays Gaussian.
  const double inverse = sum.first / sum.n / expected;
  if (!(inverse > 0)) return std::nullopt;
  const double variance = RelativeVariance(shorter.frame, expected, sum.n, r) +
                          RelativeVariance(longer.frame, bright, sum.n, r) +
                          Square(offset_sigma * (1 / shorter.told - 1 / longer.told));
  return BracketMismatch{
      0, shorter.told, longer.told, {1 / inverse, std::sqrt(variance) / inverse}};
}

}  // namespace

Result<std::optional<BracketMismatch>> LeastAgreement(const PoseRecord& pose, const RigConfig& rig,
                                                      const Calibrations& calibrations) {
  const SensorModel sensor = SensorModelOf(rig, calibrations);
  std::vector<View> views;
  for (const Exposure& e : pose.exposures) {
    const auto dark = DarkOf(rig, calibrations, e.frame);
    if (!dark) return dark.error();
    auto frame = Correct(sensor, e.frame, e.monitor, &*dark);
    if (!frame) return frame.error();
    views.push_back({std::move(frame).value(), e.frame.exposure.count(), e.colour});
  }
  const double offset_sigma = calibrations.sensor ? calibrations.sensor->exposure_offset.sigma : 0;
  std::optional<BracketMismatch> worst;
  for (const View& a : views) {
    for (const View& b : views) {
      if (!(a.told < b.told) || a.colour != b.colour) continue;
      const auto sums = CommonOf(pose, a.frame, b.frame);
      for (int c = 0; c < kChannels; ++c) {
        if (a.colour && ChannelOf(*a.colour) != c) continue;
        auto here = Compare(a, b, sums[static_cast<std::size_t>(c)], rig.radiometry, offset_sigma);
        if (!here || (worst && std::abs(here->score()) <= std::abs(worst->score()))) continue;
        worst = here;
        worst->channel = c;
      }
    }
  }
  return worst;
}

std::string TextOf(const BracketMismatch& mismatch) {
  return fmt::format(
      "{} of {:.6g} s over {:.6g} s is {:.4f} +- {:.4f} times what the exposures say",
      kChannelNames[mismatch.channel], mismatch.longer, mismatch.shorter, mismatch.ratio.value,
      mismatch.ratio.sigma);
}

}  // namespace gonio
