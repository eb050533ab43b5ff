// SPDX-License-Identifier: Apache-2.0
#include "acquisition/region_rates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "acquisition/light_colours.h"
#include "acquisition/radiometry/hdr_merge.h"
#include "acquisition/radiometry/region_statistics.h"

namespace gonio {
namespace {

using Term = UncertaintyTerm;

double Square(double x) { return x * x; }

double& At(RegionRate* rate, Term term) { return rate->terms[static_cast<std::size_t>(term)]; }

double MeanOf(const SiteImage& image, const std::vector<std::uint32_t>& sites) {
  double sum = 0;
  for (const std::uint32_t site : sites) sum += image[site];
  return sites.empty() ? 0 : sum / static_cast<double>(sites.size());
}

// Mean over what is known of one channel of the whole image, electrons/s at light 1.
double ImageMean(const MergedImage& image, int channel) {
  double sum = 0;
  double n = 0;
  const int wanted = image.format.layout == PixelLayout::kMono ? 0 : channel;
  VisitSites(image.format, [&](std::size_t site, int c) {
    if (c != wanted || (image.state[site] & (kAllSaturated | kAllBad)) != 0) return;
    sum += image.rate[site];
    n += 1;
  });
  return n > 0 ? sum / n : 0;
}

class PoseReducer {
 public:
  // Of the frames lit in this colour; empty: of those of a light without.
  PoseReducer(const PoseRecord& pose, const std::optional<LightColour>& colour,
              const RigConfig& rig, const Calibrations& calibrations)
      : pose_(pose),
        colour_(colour),
        rig_(rig),
        calibrations_(calibrations),
        flat_(FlatFor(calibrations, colour)),
        sensor_(SensorModelOf(rig, calibrations)) {
    const RadiometryConfig& r = rig.radiometry;
    options_.shared_noise = std::hypot(r.multiplicative_noise, r.monitor_noise);
    double pixels = 0;
    for (const ImageRegion& region : pose.regions) {
      pixels += static_cast<double>(region.pixels.size());
    }
    const bool mosaic =
        CountsPerPixel(rig.camera.layout) == 1 && rig.camera.layout != PixelLayout::kMono;
    const double per_region = pixels / static_cast<double>(pose.regions.size());
    options_.averaged_sites = std::max(1.0, per_region * (mosaic ? 0.25 : 1));
  }

  Result<std::vector<RegionRates>> Run() {
    for (const Exposure& exposure : pose_.exposures) {
      if (exposure.colour != colour_) continue;
      if (auto added = AddFrame(exposure); !added) return added.error();
    }
    auto merged = Merge(frames_, options_);
    if (!merged) return merged.error();
    merged_ = std::move(merged).value();
    if (flat_ != nullptr) {
      if (auto done = ApplyFlatField(*flat_, &merged_); !done) return done.error();
    }
    std::vector<RegionRates> rates;
    for (const ImageRegion& region : pose_.regions) rates.push_back(Rates(region));
    return rates;
  }

 private:
  Result<void> AddFrame(const Exposure& exposure) {
    auto dark = DarkOf(rig_, calibrations_, exposure.frame);
    if (!dark) return dark.error();
    // All frames of a pose are corrected with the same bias and rate: their error is no noise that
    // more frames average out. It becomes a term of its own (DarkTerms).
    SiteImage variance(dark->variance.size(), 0.0F);
    std::swap(variance, dark->variance);
    auto frame = Correct(sensor_, exposure.frame, exposure.monitor, &*dark);
    if (!frame) return frame.error();
    std::swap(variance, dark->variance);
    frames_.push_back(std::move(frame).value());
    darks_.push_back(std::move(dark).value());
    return {};
  }

  RegionRates Rates(const ImageRegion& region) const {
    // Where pixels differ in their directions, the brightest of them are a highlight and not dust.
    const double outlier = rig_.imaging.resolves_directions() ? 0 : 6;
    const auto statistics = StatisticsOf(merged_, region.pixels, region.lights, outlier);
    RegionRates rates;
    for (int c = 0; c < kChannels; ++c) {
      if (colour_ && ChannelOf(*colour_) != c) continue;
      rates[static_cast<std::size_t>(c)] = Rate(region, c, statistics[static_cast<std::size_t>(c)]);
    }
    return rates;
  }

  RegionRate Rate(const ImageRegion& region, int c, const ChannelStatistics& statistics) const {
    RegionRate rate;
    const bool same_light = region.lights.empty();
    const double light = same_light ? region.light : statistics.light;
    if (statistics.used == 0 || statistics.saturated > 0 || !(light > 0)) return rate;
    rate.measured = true;
    // Until the end in electrons/s of a site.
    rate.rate = same_light ? statistics.mean : statistics.mean * statistics.light;
    const std::vector<std::uint32_t> sites = SitesOf(merged_.format, region, c);
    AddNoise(sites, statistics.used, &rate);
    if (flat_ != nullptr) {
      At(&rate, Term::kFlat) = FlatTerm(*flat_, sites) * std::abs(rate.rate);
    } else {
      At(&rate, Term::kFlat) =
          rig_.imaging.resolves_directions()
              ? 0
              : statistics.unevenness / std::sqrt(statistics.used) * std::abs(rate.rate);
    }
    if (calibrations_.stray) TakeOffStrayLight(c, &rate);
    rate.rate /= light;
    for (double& term : rate.terms) term /= light;
    return rate;
  }

  // Random terms, darks and linearity: what each frame contributes by its weight in the merge.
  void AddNoise(const std::vector<std::uint32_t>& sites, int used, RegionRate* rate) const {
    const RadiometryConfig& r = rig_.radiometry;
    const double x = std::max(rate->rate, 0.0);
    std::vector<double> weights = MergeWeights(frames_, x, options_);
    double sum = 0;
    for (const double w : weights) sum += w;
    const double n = used;
    const double count = sensor_.gain;
    std::array<double, kUncertaintyTerms> squares{};
    double dark_error = 0, warmth = 0, linearity = 0, lateness = 0;
    for (std::size_t k = 0; sum > 0 && k < frames_.size(); ++k) {
      const CorrectedFrame& frame = frames_[k];
      const double share = weights[k] / sum / frame.gain();  // of an electron in this frame
      const double signal = x * frame.gain();
      const double current = count * MeanOf(darks_[k].current, sites);
      const double one = signal + current + Square(sensor_.read_noise);  // of a site, no rounding
      const auto add = [&](Term term, double variance) {
        squares[static_cast<std::size_t>(term)] += Square(share) * variance;
      };
      add(Term::kShot, (signal + current) / n);
      add(Term::kRead, Square(sensor_.read_noise) / n);
      const double shared = SharedRounding(one / Square(count));
      add(Term::kRounding, Square(count) * (1.0 / 12 / n + shared));
      add(Term::kMultiplicative, Square(r.multiplicative_noise * signal));
      add(Term::kMonitor, Square(r.monitor_noise * signal));
      // The same bias and rate in all frames: these add as they are.
      dark_error += share * count * std::sqrt(MeanOf(darks_[k].variance, sites) / n);
      warmth += share * darks_[k].temperature_sigma * current;
      lateness += share * signal / frame.exposure;
      const auto factor = sensor_.linearity.Factor((signal + current) / count);
      if (factor) linearity += share * signal * factor->sigma;
    }
    if (calibrations_.sensor) lateness *= calibrations_.sensor->exposure_offset.sigma;
    for (std::size_t i = 0; i < squares.size(); ++i) rate->terms[i] = std::sqrt(squares[i]);
    At(rate, Term::kDark) = std::hypot(dark_error, warmth);
    At(rate, Term::kLinearity) = linearity;
    At(rate, Term::kExposureRatio) = lateness;
  }

  void TakeOffStrayLight(int c, RegionRate* rate) const {
    const StrayLight& stray = (*calibrations_.stray)[static_cast<std::size_t>(c)];
    // Glare is of all that the lens sees, not of the region alone.
    const auto corrected = SubtractStrayLight({rate->rate, 0}, {ImageMean(merged_, c), 0}, stray);
    if (!corrected) {  // files with such a glare are refused
      rate->measured = false;
      return;
    }
    rate->rate = corrected->rate.value;
    for (double& term : rate->terms) term /= 1 - stray.glare.value;
    At(rate, Term::kStrayLight) = corrected->systematic;
  }

  const PoseRecord& pose_;
  const std::optional<LightColour> colour_;
  const RigConfig& rig_;
  const Calibrations& calibrations_;
  const FlatField* const flat_;
  const SensorModel sensor_;
  MergeOptions options_;
  std::vector<CorrectedFrame> frames_;
  std::vector<Dark> darks_;
  MergedImage merged_;
};

double RootOfSquares(const RegionRate& rate, bool systematic) {
  double sum = 0;
  for (int i = 0; i < kUncertaintyTerms; ++i) {
    if (IsSystematic(static_cast<Term>(i)) == systematic) {
      sum += Square(rate.terms[static_cast<std::size_t>(i)]);
    }
  }
  return std::sqrt(sum);
}

}  // namespace

std::vector<std::uint32_t> SitesOf(const SensorFormat& format, const ImageRegion& region,
                                   int channel) {
  if (format.layout == PixelLayout::kMono) return region.pixels;
  std::vector<std::uint32_t> sites;
  const auto width = static_cast<std::uint32_t>(format.width);
  for (const std::uint32_t pixel : region.pixels) {
    if (format.layout == PixelLayout::kRgb) {
      sites.push_back(kChannels * pixel + static_cast<std::uint32_t>(channel));
    } else if (BayerChannel(format.layout, static_cast<int>(pixel % width),
                            static_cast<int>(pixel / width)) == channel) {
      sites.push_back(pixel);
    }
  }
  return sites;
}

double RegionRate::random() const { return RootOfSquares(*this, false); }
double RegionRate::systematic() const { return RootOfSquares(*this, true); }

SensorModel SensorModelOf(const RigConfig& rig, const Calibrations& calibrations) {
  SensorModel model;
  model.format = calibrations.format;
  model.gain = rig.radiometry.electrons_per_count;
  model.read_noise = rig.radiometry.read_noise;
  if (calibrations.sensor) {
    model.gain = calibrations.sensor->gain.value;
    model.read_noise = calibrations.sensor->read_noise.value;
    model.exposure_offset = calibrations.sensor->exposure_offset.value;
    model.linearity = calibrations.sensor->linearity;
  }
  if (calibrations.bad_pixels) model.bad = calibrations.bad_pixels->mask;
  return model;
}

Result<Dark> DarkOf(const RigConfig& rig, const Calibrations& calibrations, const Frame& frame) {
  const double exposure = frame.exposure.count();
  if (calibrations.dark) {
    DarkLimits limits;
    // How old it may be was judged when it was read.
    limits.max_age = std::numeric_limits<double>::infinity();
    return DarkFor(*calibrations.dark, calibrations.format, exposure, frame.temperature_c,
                   calibrations.dark->created, limits);
  }
  const double gain = SensorModelOf(rig, calibrations).gain;
  const auto counts = static_cast<float>(rig.radiometry.dark_current * exposure / gain);
  const std::size_t sites = calibrations.format.sites();
  Dark dark;
  dark.counts = dark.current = SiteImage(sites, counts);
  dark.variance = SiteImage(sites, 0.0F);
  return dark;
}

Result<std::vector<RegionRates>> MeasureRates(const PoseRecord& pose, const RigConfig& rig,
                                              const Calibrations& calibrations) {
  if (pose.regions.empty() || pose.exposures.empty()) {
    return std::vector<RegionRates>(pose.regions.size());
  }
  if (!pose.exposures.front().colour) return PoseReducer(pose, {}, rig, calibrations).Run();
  std::vector<RegionRates> all(pose.regions.size());
  for (const LightColour colour : kLightColours) {
    const bool lit = std::any_of(pose.exposures.begin(), pose.exposures.end(),
                                 [&](const Exposure& e) { return e.colour == colour; });
    if (!lit) continue;
    const auto rates = PoseReducer(pose, colour, rig, calibrations).Run();
    if (!rates) return rates;
    const auto c = static_cast<std::size_t>(ChannelOf(colour));
    for (std::size_t i = 0; i < all.size(); ++i) all[i][c] = (*rates)[i][c];
  }
  return all;
}

}  // namespace gonio
