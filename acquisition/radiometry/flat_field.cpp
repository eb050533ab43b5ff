// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/flat_field.h"

#include <array>
#include <cmath>
#include <limits>

#include "brdf/brdf.h"

namespace gonio {
namespace {

Error Refusal(const std::string& why) { return {ErrorCode::kRefused, "flat field: " + why}; }

struct ChannelSum {
  double electrons = 0;
  double sites = 0;
};

}  // namespace

Result<FlatField> MeasureFlatField(const std::vector<CorrectedFrame>& frames) {
  if (frames.empty()) return Refusal("no frames");
  const SensorFormat& format = frames.front().format;
  const std::size_t sites = format.sites();
  std::vector<double> sum(sites, 0.0);
  std::vector<double> floor(sites, 0.0);
  SiteMask unusable(sites, 0);
  for (const CorrectedFrame& frame : frames) {
    const std::string difference = DifferenceOf(format, frame.format);
    if (!difference.empty()) return Refusal(difference);
    for (std::size_t i = 0; i < sites; ++i) {
      sum[i] += frame.electrons[i];
      floor[i] += frame.floor + (frame.extra.empty() ? 0 : frame.extra[i]);
      unusable[i] |= frame.unusable[i];
    }
  }
  std::array<ChannelSum, kChannels> channels;
  VisitSites(format, [&](std::size_t i, int c) {
    if (unusable[i] != 0) return;
    channels[static_cast<std::size_t>(c)].electrons += sum[i];
    channels[static_cast<std::size_t>(c)].sites += 1;
  });
  for (int c = 0; c < ChannelsOf(format.layout); ++c) {
    const ChannelSum& channel = channels[static_cast<std::size_t>(c)];
    if (!(channel.electrons > 0)) return Refusal("a channel has no signal or no good site");
  }
  FlatField flat{.format = format, .response = SiteImage(sites, 1), .sigma = SiteImage(sites)};
  VisitSites(format, [&](std::size_t i, int c) {
    flat.sigma[i] = std::numeric_limits<float>::infinity();
    if (unusable[i] != 0) return;
    const ChannelSum& channel = channels[static_cast<std::size_t>(c)];
    const double mean = channel.electrons / channel.sites;
    flat.response[i] = static_cast<float>(sum[i] / mean);
    flat.sigma[i] = static_cast<float>(std::sqrt(std::max(sum[i], 0.0) + floor[i]) / mean);
  });
  return flat;
}

Result<void> ApplyFlatField(const FlatField& flat, MergedImage* image) {
  const std::string difference = DifferenceOf(flat.format, image->format);
  if (!difference.empty()) return Refusal(difference);
  for (std::size_t i = 0; i < image->rate.size(); ++i) {
    const bool good = std::isfinite(flat.sigma[i]) && flat.response[i] > 0;
    if (!good) {
      image->rate[i] = 0;
      image->variance[i] = std::numeric_limits<float>::infinity();
      image->state[i] = kAllBad;
      continue;
    }
    image->rate[i] /= flat.response[i];
    image->variance[i] /= flat.response[i] * flat.response[i];
  }
  return {};
}

double FlatTerm(const FlatField& flat, const std::vector<std::uint32_t>& sites) {
  double sum = 0;
  double n = 0;
  for (const std::uint32_t i : sites) {
    if (!std::isfinite(flat.sigma[i])) continue;
    const double relative = flat.sigma[i] / flat.response[i];
    sum += relative * relative;
    n += 1;
  }
  return n > 0 ? std::sqrt(sum) / n : std::numeric_limits<double>::infinity();
}

}  // namespace gonio
