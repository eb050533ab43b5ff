// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "acquisition/region_rates.h"
#include "core/units.h"

namespace gonio {
namespace {

// One channel of one frame, as far as it can be known without its noise.
struct Reading {
  double electrons = 0;  // mean per pixel, signal only: black level and dark subtracted
  double gain = 0;       // electrons per f_r: responsivity * light * exposure * cos(theta_i)
  double dark = 0;       // electrons per pixel that the dark current added
  double pixels = 0;
};

double Square(double x) { return x * x; }

// Variance of Reading::electrons, electrons^2, by its origin.
struct Noise {
  double pixel = 0;     // shot and read noise of one pixel
  double pixels = 1;    // over which it averages
  double rounding = 0;  // of the mean
  double signal = 0;    // electrons
  double relative = 0;  // relative variance that the pixels share

  double total() const { return pixel / pixels + rounding + relative * Square(signal); }
};

// If the sample's reflectance were `f_r`. The expected signal is used, not the frame's own: a frame
// that by chance came out low would claim a small variance and pull the average down.
Noise NoiseOf(const Reading& reading, double f_r, const RadiometryConfig& r) {
  const double signal = std::max(f_r, 0.0) * reading.gain;
  const double pixel = signal + reading.dark + Square(r.read_noise);
  // Rounding errors of the pixels are independent only if noise spreads the pixels over several
  // counts; the second term is what they share, which a Gaussian dither of variance v counts^2
  // takes down by exp(-4 pi^2 v) (Widrow & Kollar, "Quantization Noise", 2008).
  const double count = r.electrons_per_count;
  const double shared = std::exp(-Square(2 * kPi / count) * pixel);
  const double rounding = Square(count) / 12 * (1 / reading.pixels + shared);
  const double relative = Square(r.multiplicative_noise) + Square(r.monitor_noise);
  return {pixel, reading.pixels, rounding, signal, relative};
}

double Variance(const Reading& reading, double f_r, const RadiometryConfig& r) {
  return NoiseOf(reading, f_r, r).total();
}

// The readings of one channel that are not saturated.
std::vector<Reading> Readings(const PoseRecord& pose, int c, const ImageRegion& region,
                              const RigConfig& rig) {
  std::vector<Reading> readings;
  for (const Exposure& e : pose.exposures) {
    if (e.saturated[c]) continue;
    const double exposure = e.frame.exposure.count();
    Reading reading;
    reading.dark = rig.radiometry.dark_current * exposure;
    const FrameMeans means = MeansOf(e.frame, rig.camera.full_scale, {&region, 1}, e.colour);
    if (means.pixels[c] == 0) continue;
    reading.electrons = means.counts[c] * rig.radiometry.electrons_per_count - reading.dark;
    reading.gain = rig.radiometry.responsivity[c] * e.monitor * exposure * region.light;
    reading.pixels = means.pixels[c];
    readings.push_back(reading);
  }
  return readings;
}

// What the frames' noise makes of their weighted mean, term by term. `weights` are inverse
// variances of f_r, `sum` theirs.
void SetTerms(const std::vector<Reading>& readings, const std::vector<double>& weights, double sum,
              double expected, const RadiometryConfig& r, int c, UncertaintyBudget* budget) {
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const Noise noise = NoiseOf(readings[k], expected, r);
    const double share = Square(weights[k] / sum / readings[k].gain);
    const auto add = [&](UncertaintyTerm term, double variance) {
      double& sigma = (*budget)[term][c];
      sigma = std::sqrt(Square(sigma) + share * variance);
    };
    add(UncertaintyTerm::kShot, (noise.signal + readings[k].dark) / noise.pixels);
    add(UncertaintyTerm::kRead, Square(r.read_noise) / noise.pixels);
    add(UncertaintyTerm::kRounding, noise.rounding);
    add(UncertaintyTerm::kMultiplicative, Square(r.multiplicative_noise * noise.signal));
    add(UncertaintyTerm::kMonitor, Square(r.monitor_noise * noise.signal));
  }
}

void ReduceChannel(const std::vector<Reading>& readings, const RadiometryConfig& r, int c,
                   ReducedSample* reduced) {
  double& f_r = reduced->sample.f_r[c];
  double& sigma = reduced->sample.sigma[c];
  f_r = 0;
  sigma = std::numeric_limits<double>::infinity();
  if (readings.empty()) return;
  double electrons = 0;
  double gain = 0;
  for (const Reading& reading : readings) {
    electrons += reading.electrons;
    gain += reading.gain;
  }
  const double expected = electrons / gain;
  std::vector<double> weights;
  double sum = 0;
  double weighted = 0;
  for (const Reading& reading : readings) {
    const double weight = Square(reading.gain) / Variance(reading, expected, r);
    weights.push_back(weight);
    sum += weight;
    weighted += weight * reading.electrons / reading.gain;
  }
  f_r = weighted / sum;
  sigma = 1 / std::sqrt(sum);
  SetTerms(readings, weights, sum, expected, r, c, &reduced->budget);
}

ReducedSample ReduceRegion(const PoseRecord& pose, const ImageRegion& region,
                           const RigConfig& rig) {
  ReducedSample reduced;
  reduced.sample.directions = region.directions;
  for (int c = 0; c < kChannels; ++c) {
    std::vector<Reading> readings;
    if (region.light > 0) readings = Readings(pose, c, region, rig);
    ReduceChannel(readings, rig.radiometry, c, &reduced);
  }
  return reduced;
}

// What wrong directions do to the cosine that is divided out. What they do to f_r itself depends on
// its slope, which a sample does not tell: that is for the fit to bear.
void AddAngle(const RigConfig& rig, ReducedSample* reduced) {
  if (!rig.sigma_of_directions) return;
  const double theta_i = std::acos(std::clamp(reduced->sample.directions.cos_theta_i(), 0.0, 1.0));
  for (int c = 0; c < kChannels; ++c) {
    reduced->budget[UncertaintyTerm::kAngle][c] =
        AngleTerm(reduced->sample.f_r[c], 0, theta_i, *rig.sigma_of_directions);
  }
}

std::vector<ReducedSample> ReduceByRig(const PoseRecord& pose, const RigConfig& rig) {
  std::vector<ReducedSample> samples;
  for (const ImageRegion& region : pose.regions) {
    samples.push_back(ReduceRegion(pose, region, rig));
    AddAngle(rig, &samples.back());
  }
  return samples;
}

// R of one channel. The rig's own is for electrons as the rig counts them: a gain that is not well
// known makes it uncertain, while one that a standard told had the same gain.
MeasuredValue ResponsivityOf(const RigConfig& rig, const Calibrations& calibrations, int c) {
  if (calibrations.responsivity) {
    return calibrations.responsivity->responsivity[static_cast<std::size_t>(c)];
  }
  const double gain = calibrations.sensor ? calibrations.sensor->gain.relative() : 0;
  return {rig.radiometry.responsivity[c], rig.radiometry.responsivity[c] * gain};
}

ReducedSample FromRates(const RegionRates& rates, const ImageRegion& region, const RigConfig& rig,
                        const Calibrations& calibrations) {
  ReducedSample reduced;
  reduced.sample.directions = region.directions;
  reduced.sample.sigma.setConstant(std::numeric_limits<double>::infinity());
  for (int c = 0; c < kChannels; ++c) {
    const RegionRate& rate = rates[static_cast<std::size_t>(c)];
    if (!rate.measured) continue;
    const MeasuredValue responsivity = ResponsivityOf(rig, calibrations, c);
    reduced.sample.f_r[c] = rate.rate / responsivity.value;
    reduced.sample.sigma[c] = rate.random() / responsivity.value;
    for (std::size_t i = 0; i < rate.terms.size(); ++i) {
      reduced.budget.terms[i][c] = rate.terms[i] / responsivity.value;
    }
    reduced.budget[UncertaintyTerm::kResponsivity][c] =
        std::abs(reduced.sample.f_r[c]) * responsivity.relative();
  }
  return reduced;
}

// About how many pixels of each colour a sample is averaged over.
Rgb ExpectedPixels(const DirectionPair& pair, const RigConfig& rig) {
  double pixels = static_cast<double>(rig.camera.width) * rig.camera.height;
  if (rig.imaging.resolves_directions()) {
    // The patch is a disc that is seen at an angle.
    const double radius =
        rig.imaging.patch_radius * rig.imaging.focal_length / rig.imaging.camera_distance;
    pixels = std::min(pixels, kPi * Square(radius) * pair.cos_theta_o()) / rig.samples_per_image;
  }
  const bool mosaic =
      CountsPerPixel(rig.camera.layout) == 1 && rig.camera.layout != PixelLayout::kMono;
  const Rgb share = mosaic ? Rgb(0.25, 0.5, 0.25) : Rgb::Ones();
  return (pixels * share).max(1);
}

}  // namespace

std::vector<BrdfSample> SamplesOf(const std::vector<ReducedSample>& reduced) {
  std::vector<BrdfSample> samples;
  for (const ReducedSample& one : reduced) samples.push_back(one.sample);
  return samples;
}

Result<std::vector<ReducedSample>> Reduce(const PoseRecord& pose, const RigConfig& rig,
                                          const Calibrations& calibrations) {
  if (calibrations.empty()) return ReduceByRig(pose, rig);
  const auto rates = MeasureRates(pose, rig, calibrations);
  if (!rates) return rates.error();
  std::vector<ReducedSample> samples;
  for (std::size_t i = 0; i < rates->size(); ++i) {
    samples.push_back(FromRates((*rates)[i], pose.regions[i], rig, calibrations));
    AddAngle(rig, &samples.back());
  }
  return samples;
}

std::vector<BrdfSample> Reduce(const PoseRecord& pose, const RigConfig& rig) {
  return SamplesOf(ReduceByRig(pose, rig));
}

void Believe(const Calibrations& calibrations, RigConfig* rig) {
  RadiometryConfig& r = rig->radiometry;
  if (calibrations.sensor) {
    r.electrons_per_count = calibrations.sensor->gain.value;
    r.read_noise = calibrations.sensor->read_noise.value;
  }
  if (calibrations.dark) {
    const SiteImage& rate = calibrations.dark->fits.front().rate;
    double sum = 0;
    for (const float one : rate) sum += one;
    r.dark_current = std::max(0.0, r.electrons_per_count * sum / static_cast<double>(rate.size()));
  }
  if (!calibrations.responsivity) return;
  for (int c = 0; c < kChannels; ++c) {
    r.responsivity[c] = calibrations.responsivity->responsivity[static_cast<std::size_t>(c)].value;
  }
}

Rgb ExpectedSigma(const DirectionPair& pair, const Rgb& f_r, const Rgb& exposures,
                  const RigConfig& rig) {
  const RadiometryConfig& r = rig.radiometry;
  Rgb sigma = Rgb::Constant(std::numeric_limits<double>::infinity());
  const Rgb pixels = ExpectedPixels(pair, rig);
  for (int c = 0; c < kChannels; ++c) {
    const double light = pair.cos_theta_i() * rig.light_level * exposures[c];
    if (!(light > 0)) continue;
    Reading reading;
    reading.dark = r.dark_current * exposures[c];
    reading.pixels = pixels[c];
    reading.gain = r.responsivity[c] * light;
    sigma[c] = std::sqrt(Variance(reading, f_r[c], r)) / reading.gain;
  }
  return sigma;
}

}  // namespace gonio
