// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exposure.h"

#include <algorithm>
#include <cmath>

#include "acquisition/light_colours.h"
#include "core/check.h"

namespace gonio {
namespace {

// A lift to min_fraction aims this much higher, so that noise does not ask for another frame.
constexpr double kMargin = 1.5;
// Below this many counts a mean says little about the rate; it bounds how far a frame can lengthen.
constexpr double kFaintCounts = 1;

// Hands every colour that a pixel has to visit(channel, count).
template <typename Visit>
void VisitCounts(const Frame& frame, std::uint32_t pixel, const std::optional<LightColour>& colour,
                 const Visit& visit) {
  if (colour) {
    GONIO_CHECK(frame.layout == PixelLayout::kMono, "coloured light is for mono cameras");
    visit(ChannelOf(*colour), frame.counts[pixel]);
    return;
  }
  switch (frame.layout) {
    case PixelLayout::kRgb:
      for (int c = 0; c < kChannels; ++c) visit(c, frame.counts[3 * std::size_t{pixel} + c]);
      return;
    case PixelLayout::kMono:
      for (int c = 0; c < kChannels; ++c) visit(c, frame.counts[pixel]);
      return;
    default:
      visit(BayerChannel(frame.layout, static_cast<int>(pixel % frame.width),
                         static_cast<int>(pixel / frame.width)),
            frame.counts[pixel]);
  }
}

// What all frames so far say about one channel.
struct ChannelView {
  bool seen = false;            // unsaturated in some frame; the next three hold that longest frame
  double exposure = 0;          // s
  double counts = 0;            // net mean
  bool good = false;            // reached min_fraction in it
  double shortest_clipped = 0;  // s, shortest frame that saturated it; 0 = none
  double clipped_pixels = 0;    // fraction of the pixels in that frame

  double rate() const { return std::max(counts, kFaintCounts) / exposure; }
};

ChannelView View(std::span<const Exposure> taken, const std::vector<FrameMeans>& means, int c,
                 double enough_counts) {
  ChannelView view;
  for (std::size_t i = 0; i < taken.size(); ++i) {
    const double exposure = taken[i].frame.exposure.count();
    if (means[i].pixels[c] == 0) continue;
    if (taken[i].saturated[c]) {
      if (view.shortest_clipped == 0 || exposure < view.shortest_clipped) {
        view.shortest_clipped = exposure;
        view.clipped_pixels = means[i].saturated_fraction[c];
      }
    } else if (!view.seen || exposure > view.exposure) {
      view.seen = true;
      view.exposure = exposure;
      view.counts = means[i].counts[c];
      view.good = view.counts >= enough_counts;
    }
  }
  return view;
}

std::vector<FrameMeans> MeansOfAll(std::span<const Exposure> taken,
                                   std::span<const ImageRegion> regions, const RigConfig& rig) {
  std::vector<FrameMeans> means;
  means.reserve(taken.size());
  for (const Exposure& e : taken) {
    means.push_back(MeansOf(e.frame, rig.camera.full_scale, regions, e.colour));
  }
  return means;
}

double Clamp(double exposure, const CameraInfo& camera) {
  return std::clamp(exposure, camera.min_exposure.count(), camera.max_exposure.count());
}

// Aims a channel of `rate` counts per second at the target, or past the soft limit only at
// min_fraction.
double Aim(double rate, const RigConfig& rig) {
  const double full = rig.camera.full_scale;
  const double soft = rig.exposure.soft_limit.count();
  const double target = rig.exposure.target_fraction * full / rate;
  if (target <= soft) return target;
  return std::max(soft, kMargin * rig.exposure.min_fraction * full / rate);
}

std::optional<double> Shorter(const std::array<ChannelView, kChannels>& views,
                              const CameraInfo& camera) {
  const bool any_seen =
      std::any_of(views.begin(), views.end(), [](const ChannelView& v) { return v.seen; });
  std::optional<double> next;
  for (const ChannelView& view : views) {
    if (view.seen || view.shortest_clipped <= 1.05 * camera.min_exposure.count()) {
      continue;  // already the shortest, give or take the camera's own step
    }
    const double divisor = view.clipped_pixels < 0.5 ? 2 : any_seen ? 4 : 16;
    const double wanted = Clamp(view.shortest_clipped / divisor, camera);
    next = next ? std::min(*next, wanted) : wanted;
  }
  return next;
}

// The exposure that would make this channel good, if there is one that differs from those taken.
std::optional<double> Longer(const ChannelView& view, bool brightest, const RigConfig& rig) {
  const double lift = kMargin * rig.exposure.min_fraction * rig.camera.full_scale / view.rate();
  double wanted = Clamp(brightest ? Aim(view.rate(), rig) : lift, rig.camera);
  // Between a frame that was too dark and one that was too bright, halve the ratio.
  if (view.shortest_clipped > 0 && wanted >= view.shortest_clipped) {
    wanted = std::sqrt(view.exposure * view.shortest_clipped);
  }
  // Nothing that a repetition would not give.
  if (wanted <= view.exposure * 1.05) return std::nullopt;
  return wanted;
}

}  // namespace

FrameMeans MeansOf(const Frame& frame, int full_scale, std::span<const ImageRegion> regions,
                   const std::optional<LightColour>& colour) {
  FrameMeans means;
  const auto add = [&](int channel, std::uint16_t count) {
    means.counts[channel] += count;
    if (count >= full_scale) means.saturated_fraction[channel] += 1;
    means.pixels[channel] += 1;
  };
  for (const ImageRegion& region : regions) {
    for (const std::uint32_t pixel : region.pixels) VisitCounts(frame, pixel, colour, add);
  }
  const Rgb pixels = means.pixels.max(1);
  means.counts = (means.pixels > 0).select(means.counts / pixels - frame.black_level, 0);
  means.saturated_fraction /= pixels;
  return means;
}

Rgb CountRates(const Rgb& f_r, double cos_theta_i, double light,
               const RadiometryConfig& radiometry) {
  return radiometry.responsivity * f_r * (cos_theta_i * light / radiometry.electrons_per_count);
}

Seconds FirstExposure(const Rgb& rates, const RigConfig& rig) {
  const double soft = rig.exposure.soft_limit.count();
  const double brightest = rates.maxCoeff();
  const bool known = rates.allFinite() && brightest > 0;
  // A prediction may be wrong, so the first frame never costs more than the soft limit.
  const double wanted = known ? std::min(soft, Aim(brightest, rig)) : soft;
  return Seconds(Clamp(wanted, rig.camera));
}

std::optional<Seconds> NextExposure(std::span<const Exposure> taken,
                                    std::span<const ImageRegion> regions, const RigConfig& rig) {
  GONIO_CHECK(!taken.empty(), "nothing was exposed");
  const std::vector<FrameMeans> means = MeansOfAll(taken, regions, rig);
  const double enough = rig.exposure.min_fraction * rig.camera.full_scale;
  std::array<ChannelView, kChannels> views;
  for (int c = 0; c < kChannels; ++c) views[c] = View(taken, means, c, enough);

  if (const auto shorter = Shorter(views, rig.camera)) return Seconds(*shorter);

  std::array<const ChannelView*, kChannels> order;
  for (int c = 0; c < kChannels; ++c) order[c] = &views[c];
  std::sort(order.begin(), order.end(), [](const ChannelView* a, const ChannelView* b) {
    return a->seen && (!b->seen || a->rate() > b->rate());
  });
  for (const ChannelView* view : order) {
    if (!view->seen || view->good) continue;
    if (const auto longer = Longer(*view, view == order[0], rig)) return Seconds(*longer);
  }
  return std::nullopt;
}

std::optional<double> RateOf(std::span<const Exposure> taken, std::span<const ImageRegion> regions,
                             int channel, const RigConfig& rig) {
  const ChannelView view = View(taken, MeansOfAll(taken, regions, rig), channel, 0);
  return view.seen ? std::optional<double>(view.rate()) : std::nullopt;
}

}  // namespace gonio
