// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/bad_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acquisition/radiometry/measured_value.h"
#include "brdf/brdf.h"
#include "core/check.h"

namespace gonio {
namespace {

// Per channel, the value above which a site stands out.
std::array<double, kChannels> Thresholds(const SensorFormat& format, const SiteImage& values,
                                         double spreads) {
  std::array<double, kChannels> thresholds{};
  for (int c = 0; c < ChannelsOf(format.layout); ++c) {
    const RobustSpread spread = RobustSpreadOf(ChannelValues(format, values, c, {}));
    // Noiseless sites are all alike; a billionth keeps their last digits out.
    const double least = 1e-9 + 1e-6 * std::abs(spread.median);
    thresholds[static_cast<std::size_t>(c)] =
        spread.median + spreads * std::max(spread.sigma, least);
  }
  return thresholds;
}

}  // namespace

double BadPixels::fraction() const {
  const auto bad = std::count_if(mask.begin(), mask.end(), [](auto bits) { return bits != 0; });
  return mask.empty() ? 0 : static_cast<double>(bad) / static_cast<double>(mask.size());
}

BadPixels FindBadPixels(const SensorFormat& format, const DarkFit& dark, const SiteImage& response,
                        const BadPixelLimits& limits) {
  GONIO_CHECK(dark.rate.size() == format.sites(), "a rate for each site");
  GONIO_CHECK(response.empty() || response.size() == format.sites(), "a response for each site");
  const auto hot = Thresholds(format, dark.rate, limits.hot);
  const auto noisy = Thresholds(format, dark.noise, limits.noisy);
  BadPixels bad;
  bad.mask.assign(format.sites(), 0);
  VisitSites(format, [&](std::size_t i, int channel) {
    const auto c = static_cast<std::size_t>(channel);
    if (dark.rate[i] > hot[c]) {
      bad.mask[i] |= kHotPixel;
      ++bad.hot;
    }
    if (dark.noise[i] > noisy[c]) {
      bad.mask[i] |= kNoisyPixel;
      ++bad.noisy;
    }
    if (!response.empty() && !(std::abs(response[i] - 1) <= limits.dead)) {
      bad.mask[i] |= kDeadPixel;
      ++bad.dead;
    }
  });
  return bad;
}

}  // namespace gonio
