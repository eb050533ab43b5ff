// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/dark_library.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "acquisition/radiometry/measured_value.h"
#include "core/units.h"

namespace gonio {
namespace {

Error Refusal(const std::string& why) { return {ErrorCode::kRefused, "dark frames: " + why}; }

using Group = std::map<double, std::vector<const Frame*>>;  // by exposure

// a_k and b_k of the weighted line.
void SetCoefficients(std::vector<DarkFit::Level>* levels) {
  double n = 0;
  double sum = 0;
  for (const auto& level : *levels) {
    n += level.frames;
    sum += level.frames * level.exposure;
  }
  const double centre = sum / n;
  double spread = 0;
  for (const auto& level : *levels) {
    spread += level.frames * (level.exposure - centre) * (level.exposure - centre);
  }
  for (auto& level : *levels) {
    level.to_rate = level.frames * (level.exposure - centre) / spread;
    level.to_bias = level.frames / n - centre * level.to_rate;
  }
}

// Adds the frames of one exposure to the line, and their scatter to `squares`.
void AddLevel(const std::vector<const Frame*>& frames, const DarkFit::Level& level, DarkFit* fit,
              std::vector<double>* squares) {
  const std::size_t sites = fit->bias.size();
  std::vector<double> mean(sites, 0.0);
  for (const Frame* frame : frames) {
    const double black = frame->black_level;
    for (std::size_t i = 0; i < sites; ++i) mean[i] += frame->counts[i] - black;
  }
  for (double& m : mean) m /= level.frames;
  for (const Frame* frame : frames) {
    for (std::size_t i = 0; i < sites; ++i) {
      const double d = frame->counts[i] - frame->black_level - mean[i];
      (*squares)[i] += d * d;
    }
  }
  for (std::size_t i = 0; i < sites; ++i) {
    fit->bias[i] += static_cast<float>(level.to_bias * mean[i]);
    fit->rate[i] += static_cast<float>(level.to_rate * mean[i]);
  }
}

// The mean of the frames' own variance less the shot noise of the dark current, over the sites with
// less than the typical current. Not their median: of few frames it is below the mean.
double ReadVariance(const DarkFit& fit, const std::vector<double>& squares, int freedom,
                    double gain, double mean_exposure) {
  const double typical = Median(fit.rate);
  double sum = 0;
  double n = 0;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    if (fit.rate[i] > typical) continue;
    sum += squares[i] / freedom - fit.rate[i] * mean_exposure / gain;
    n += 1;
  }
  return std::max(sum / n, 1.0 / 12);
}

DarkFit FitOf(const Group& group, std::size_t sites, double temperature, double gain) {
  DarkFit fit;
  fit.temperature_c = temperature;
  fit.bias.assign(sites, 0);
  fit.rate.assign(sites, 0);
  int freedom = 0;
  double exposures = 0;
  for (const auto& [exposure, frames] : group) {
    fit.levels.push_back({.exposure = exposure, .frames = static_cast<int>(frames.size())});
    freedom += static_cast<int>(frames.size()) - 1;
    exposures += (static_cast<double>(frames.size()) - 1) * exposure;
  }
  SetCoefficients(&fit.levels);
  std::vector<double> squares(sites, 0.0);
  std::size_t k = 0;
  for (const auto& [exposure, frames] : group) AddLevel(frames, fit.levels[k++], &fit, &squares);
  fit.noise.resize(sites);
  for (std::size_t i = 0; i < sites; ++i) {
    fit.noise[i] = static_cast<float>(std::sqrt(squares[i] / freedom));
  }
  fit.read_variance = ReadVariance(fit, squares, freedom, gain, exposures / freedom);
  return fit;
}

// Why this group is not enough for a line; empty if it is.
std::string Lack(const Group& group) {
  if (group.size() < 2) return "one exposure, needs 2";
  for (const auto& [exposure, frames] : group) {
    if (frames.size() < 2) return fmt::format("one frame of {} s, needs 2", exposure);
  }
  return "";
}

// The fit nearest to the temperature; null if the camera does not tell and there are several.
const DarkFit* Nearest(const DarkLibrary& library, std::optional<double> temperature) {
  if (!temperature) return library.fits.size() == 1 ? &library.fits.front() : nullptr;
  return &*std::min_element(library.fits.begin(), library.fits.end(),
                            [t = *temperature](const DarkFit& a, const DarkFit& b) {
                              return std::abs(a.temperature_c - t) < std::abs(b.temperature_c - t);
                            });
}

Dark Evaluate(const DarkFit& fit, double gain, double exposure) {
  const std::size_t sites = fit.bias.size();
  // The variance is a line in the rate.
  double at_zero = SharedRounding(fit.read_variance);
  double per_rate = 0;
  for (const auto& level : fit.levels) {
    const double c = level.to_bias + level.to_rate * exposure;
    at_zero += c * c * fit.read_variance / level.frames;
    per_rate += c * c * level.exposure / gain / level.frames;
  }
  Dark dark;
  dark.counts.resize(sites);
  dark.variance.resize(sites);
  dark.current.resize(sites);
  const auto t = static_cast<float>(exposure);
  for (std::size_t i = 0; i < sites; ++i) {
    const float rate = std::max(fit.rate[i], 0.0F);
    dark.counts[i] = fit.bias[i] + fit.rate[i] * t;
    dark.current[i] = rate * t;
    dark.variance[i] = static_cast<float>(at_zero + per_rate * rate);
  }
  return dark;
}

}  // namespace

double SharedRounding(double variance) {
  return std::exp(-4 * kPi * kPi * std::max(0.0, variance)) / 12;
}

Result<DarkLibrary> MeasureDark(const SensorFormat& format, const std::vector<Frame>& frames,
                                double gain, std::int64_t created, double temperature_step) {
  std::vector<const Frame*> sorted;
  for (const Frame& frame : frames) {
    const std::string difference = DifferenceOf(format, frame);
    if (!difference.empty()) return Refusal(difference);
    sorted.push_back(&frame);
  }
  if (sorted.empty()) return Refusal("none");
  std::stable_sort(sorted.begin(), sorted.end(), [](const Frame* a, const Frame* b) {
    return a->temperature_c.value_or(0) < b->temperature_c.value_or(0);
  });
  DarkLibrary library{.format = format, .gain = gain, .created = created, .fits = {}};
  for (std::size_t i = 0; i < sorted.size();) {
    const double first = sorted[i]->temperature_c.value_or(0);
    Group group;
    double sum = 0;
    std::size_t end = i;
    for (; end < sorted.size(); ++end) {
      const double temperature = sorted[end]->temperature_c.value_or(0);
      if (temperature - first > temperature_step) break;
      group[sorted[end]->exposure.count()].push_back(sorted[end]);
      sum += temperature;
    }
    const std::string lack = Lack(group);
    if (!lack.empty()) return Refusal(fmt::format("at {} degrees {}", first, lack));
    library.fits.push_back(FitOf(group, format.sites(), sum / static_cast<double>(end - i), gain));
    i = end;
  }
  return library;
}

Result<Dark> DarkFor(const DarkLibrary& library, const SensorFormat& format, double exposure,
                     std::optional<double> temperature_c, std::int64_t now,
                     const DarkLimits& limits) {
  const std::string difference = DifferenceOf(library.format, format);
  if (!difference.empty()) return Refusal(difference);
  const auto age = static_cast<double>(now - library.created);
  if (age < 0) return Refusal("taken after the frame; a clock is wrong");
  if (age > limits.max_age) {
    return Refusal(
        fmt::format("{:.1f} days old, the limit is {:.1f}", age / 86400, limits.max_age / 86400));
  }
  const DarkFit* fit = Nearest(library, temperature_c);
  if (fit == nullptr) return Refusal("of several temperatures, and the frame tells none");
  const double off = temperature_c ? std::abs(*temperature_c - fit->temperature_c) : 0;
  if (off > limits.max_temperature_difference) {
    return Refusal(fmt::format("none within {} degrees of {}", limits.max_temperature_difference,
                               *temperature_c));
  }
  if (!(exposure >= 0) || exposure > fit->levels.back().exposure) {
    return Refusal(fmt::format("{} s is longer than {} s, the longest of them", exposure,
                               fit->levels.back().exposure));
  }
  Dark dark = Evaluate(*fit, library.gain, exposure);
  dark.temperature_sigma = std::exp2(off / limits.doubling) - 1;
  return dark;
}

}  // namespace gonio
