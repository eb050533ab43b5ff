// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

// Variance of Reading::electrons if the sample's reflectance were `f_r`. The expected signal is
// used, not the frame's own: a frame that by chance came out low would claim a small variance and
// pull the average down.
double Variance(const Reading& reading, double f_r, const RadiometryConfig& r) {
  const double signal = std::max(f_r, 0.0) * reading.gain;
  const double pixel = signal + reading.dark + Square(r.read_noise);
  // Rounding errors of the pixels are independent only if noise spreads the pixels over several
  // counts; the second term is what they share, which a Gaussian dither of variance v counts^2
  // takes down by exp(-4 pi^2 v) (Widrow & Kollar, "Quantization Noise", 2008).
  const double count = r.electrons_per_count;
  const double shared = std::exp(-Square(2 * kPi / count) * pixel);
  const double rounding = Square(count) / 12 * (1 / reading.pixels + shared);
  const double relative = Square(r.multiplicative_noise) + Square(r.monitor_noise);
  return pixel / reading.pixels + rounding + relative * Square(signal);
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
    const FrameMeans means = MeansOf(e.frame, rig.camera.full_scale, {&region, 1});
    if (means.pixels[c] == 0) continue;
    reading.electrons = means.counts[c] * rig.radiometry.electrons_per_count - reading.dark;
    reading.gain = rig.radiometry.responsivity[c] * e.monitor * exposure * region.light;
    reading.pixels = means.pixels[c];
    readings.push_back(reading);
  }
  return readings;
}

void ReduceChannel(const std::vector<Reading>& readings, const RadiometryConfig& r, double* f_r,
                   double* sigma) {
  *f_r = 0;
  *sigma = std::numeric_limits<double>::infinity();
  if (readings.empty()) return;
  double electrons = 0;
  double gain = 0;
  for (const Reading& reading : readings) {
    electrons += reading.electrons;
    gain += reading.gain;
  }
  const double expected = electrons / gain;
  double weights = 0;
  double weighted = 0;
  for (const Reading& reading : readings) {
    const double weight = Square(reading.gain) / Variance(reading, expected, r);
    weights += weight;
    weighted += weight * reading.electrons / reading.gain;
  }
  *f_r = weighted / weights;
  *sigma = 1 / std::sqrt(weights);
}

BrdfSample ReduceRegion(const PoseRecord& pose, const ImageRegion& region, const RigConfig& rig) {
  BrdfSample sample;
  sample.directions = region.directions;
  for (int c = 0; c < kChannels; ++c) {
    std::vector<Reading> readings;
    if (region.light > 0) readings = Readings(pose, c, region, rig);
    ReduceChannel(readings, rig.radiometry, &sample.f_r[c], &sample.sigma[c]);
  }
  return sample;
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

std::vector<BrdfSample> Reduce(const PoseRecord& pose, const RigConfig& rig) {
  std::vector<BrdfSample> samples;
  for (const ImageRegion& region : pose.regions) {
    samples.push_back(ReduceRegion(pose, region, rig));
  }
  return samples;
}

Rgb ExpectedSigma(const DirectionPair& pair, const Rgb& f_r, Seconds exposure,
                  const RigConfig& rig) {
  const RadiometryConfig& r = rig.radiometry;
  Rgb sigma = Rgb::Constant(std::numeric_limits<double>::infinity());
  const double light = pair.cos_theta_i() * rig.light_level * exposure.count();
  if (!(light > 0)) return sigma;
  const Reading dark{
      .electrons = 0, .gain = 0, .dark = r.dark_current * exposure.count(), .pixels = 0};
  const Rgb pixels = ExpectedPixels(pair, rig);
  for (int c = 0; c < kChannels; ++c) {
    Reading reading = dark;
    reading.pixels = pixels[c];
    reading.gain = r.responsivity[c] * light;
    sigma[c] = std::sqrt(Variance(reading, f_r[c], r)) / reading.gain;
  }
  return sigma;
}

}  // namespace gonio
