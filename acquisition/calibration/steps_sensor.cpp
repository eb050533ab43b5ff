// SPDX-License-Identifier: Apache-2.0
// Darks, photon transfer, flat: what is the sensor's own.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "acquisition/calibration/step_frames.h"
#include "acquisition/exposure.h"
#include "acquisition/radiometry/exposure_offset.h"
#include "acquisition/radiometry/photon_transfer.h"
#include "acquisition/region_rates.h"

namespace gonio {
namespace {

constexpr int kDarkFrames = 16;
constexpr int kTransferFrames = 8;
constexpr int kShortestFrames = 32;  // at the camera's shortest exposure
constexpr double kDimEnough = 0.1;   // of full scale, to tell the exposures' offset
constexpr int kFlatFrames = 16;

std::string BadPixelsLine(const BadPixels& bad) {
  return fmt::format("bad sites        {:.3f} %: {} hot, {} noisy, {} dead", 100 * bad.fraction(),
                     bad.hot, bad.noisy, bad.dead);
}

// Of full scale, for the brightest channel; the last ones for the channels that are dimmer.
std::vector<double> TransferLevels() {
  std::vector<double> levels = {0.01, 0.02, 0.04, 0.07};
  for (double level = 0.1; level < 1.001; level += 0.05) levels.push_back(level);
  for (const double level : {1.15, 1.4, 1.8}) levels.push_back(level);
  return levels;
}

std::vector<FlatPair> PairsOf(std::vector<StoredFrame> frames) {
  std::vector<FlatPair> pairs;
  for (std::size_t i = 0; i + 1 < frames.size(); i += 2) {
    pairs.push_back({std::move(frames[i].frame), std::move(frames[i + 1].frame), frames[i].monitor,
                     frames[i + 1].monitor});
  }
  return pairs;
}

// The points of one exposure and channel as one, whose light is their mean.
std::vector<TransferPoint> Joined(const std::vector<TransferPoint>& points, int channel) {
  std::map<double, std::vector<TransferPoint>> levels;
  for (const TransferPoint& point : points) {
    if (point.channel == channel) levels[point.exposure].push_back(point);
  }
  std::vector<TransferPoint> joined;
  for (const auto& [exposure, level] : levels) {
    TransferPoint mean = level.front();
    const auto n = static_cast<double>(level.size());
    mean.mean = mean.monitor = 0;
    for (const TransferPoint& point : level) {
      mean.mean += point.mean / n;
      mean.monitor += point.monitor / n;
      mean.clipped = std::max(mean.clipped, point.clipped);
    }
    mean.mean_sigma /= std::sqrt(n);
    joined.push_back(mean);
  }
  return joined;
}

double MeanRate(const DarkLibrary& dark) {
  double sum = 0;
  for (const float rate : dark.fits.front().rate) sum += rate;
  return sum / static_cast<double>(dark.fits.front().rate.size());
}

// The channel that most light reaches: it sees the whole range.
int Brightest(const PhotonTransfer& transfer) {
  std::array<double, kChannels> means{};
  for (const TransferPoint& point : transfer.points) {
    if (point.used) means[static_cast<std::size_t>(point.channel)] += point.mean / point.exposure;
  }
  return static_cast<int>(std::max_element(means.begin(), means.end()) - means.begin());
}

// What a photon transfer series says.
struct Series {
  PhotonTransfer transfer;  // of counts as they are
  LinearityFit line;
  Result<ExposureOffset> offset;
  SensorCalibration sensor;
};

// `shortest`: pairs of the shortest exposure, which see little but its offset.
Result<ExposureOffset> EvaluateOffset(const StepFrames& step, const Calibrations& earlier,
                                      const PhotonTransfer& transfer,
                                      const std::vector<FlatPair>& shortest) {
  TransferOptions options;
  options.bad = earlier.bad_pixels->mask;
  auto points = TransferPoints(step.format(), shortest, options);
  if (!points) return points.error();
  points->insert(points->end(), transfer.points.begin(), transfer.points.end());
  const RadiometryConfig& r = step.rig().radiometry;
  ExposureOffsetOptions offset;
  offset.light_noise = std::hypot(r.multiplicative_noise, r.monitor_noise);
  offset.max_counts = kDimEnough * step.format().full_scale;
  offset.bad = earlier.bad_pixels->mask;
  return MeasureExposureOffset(*points, earlier.dark->fits.front(), step.format(), offset);
}

// `times`: frames of each exposure.
Result<Series> EvaluateSeries(const StepFrames& step, const Calibrations& earlier,
                              const std::vector<FlatPair>& pairs,
                              const std::vector<FlatPair>& shortest, int times) {
  const SensorFormat& format = step.format();
  TransferOptions options;
  options.bad = earlier.bad_pixels->mask;
  auto transfer = MeasurePhotonTransfer(format, pairs, options);
  if (!transfer) return transfer.error();
  auto offset = EvaluateOffset(step, earlier, *transfer, shortest);
  const MeasuredValue late = offset ? offset->offset : MeasuredValue{};
  LinearityOptions linear;
  linear.channel = Brightest(*transfer);
  linear.dark_rate = MeanRate(*earlier.dark);
  const RadiometryConfig& r = step.rig().radiometry;
  linear.light_noise = std::hypot(r.multiplicative_noise, r.monitor_noise) / std::sqrt(times / 2.0);
  linear.min_counts = 0.01 * format.full_scale;
  std::vector<TransferPoint> levels = Joined(transfer->points, linear.channel);
  for (TransferPoint& level : levels) level.exposure += late.value;
  auto line = MeasureLinearity(levels, linear);
  if (!line) return line.error();
  Series series{std::move(transfer).value(), std::move(line).value(), std::move(offset), {}};
  SensorCalibration& sensor = series.sensor;
  sensor = {series.transfer.gain, series.transfer.read_noise, series.transfer.full_well, late,
            Linearity::Identity(format.full_scale)};
  if (series.line.significant) sensor.linearity = series.line.table;
  return series;
}

// A camera whose shortest exposures are too bright to tell is believed.
std::string ExposureLine(const Result<ExposureOffset>& offset) {
  if (!offset) return "exposures        as told: " + offset.error().message;
  return fmt::format("exposures        {:.3g} +- {:.2g} us longer than told; chi^2 {:.1f} of {}",
                     1e6 * offset->offset.value, 1e6 * offset->offset.sigma, offset->chi_squared,
                     offset->degrees_of_freedom);
}

std::vector<std::string> LinesOf(const Series& series) {
  const SensorCalibration& sensor = series.sensor;
  const PhotonTransfer& transfer = series.transfer;
  return {fmt::format("gain             {:.4g} +- {:.2g} electrons/count", sensor.gain.value,
                      sensor.gain.sigma),
          fmt::format("read noise       {:.4g} +- {:.2g} electrons{}", sensor.read_noise.value,
                      sensor.read_noise.sigma,
                      transfer.read_noise_hidden ? ", an upper limit: rounding hides it" : ""),
          fmt::format("full well        {}{:.5g} +- {:.2g} electrons{}",
                      transfer.full_well_reached ? "" : "at least ", sensor.full_well.value,
                      sensor.full_well.sigma,
                      transfer.full_well_is_full_scale ? ", where the converter ends" : ""),
          ExposureLine(series.offset),
          fmt::format("linearity        {:.2f} +- {:.2f} % off at most: {}",
                      100 * series.line.max_residual, 100 * series.line.max_residual_sigma,
                      series.line.significant ? "corrected" : "not significant, not corrected")};
}

// How much less light than in the middle each pixel's part of the tile gets, so that the flat is of
// the camera alone. All 1 where pixels do not have their own directions.
std::vector<float> LightOnPixels(const RigConfig& rig, const StepFrames& step) {
  const auto pixels = static_cast<std::size_t>(rig.camera.width) * rig.camera.height;
  std::vector<float> lights(pixels, 1.0F);
  if (!rig.imaging.resolves_directions()) return lights;
  Imaging wide = step.imaging();
  wide.patch_radius = 0.99 * std::min(wide.camera_distance, wide.light_distance);
  const auto regions =
      RegionsOf(wide, step.arms(), rig.camera.width, rig.camera.height, rig.geometry.max_polar);
  for (const ImageRegion& region : regions) {
    for (std::size_t i = 0; i < region.pixels.size() && !region.lights.empty(); ++i) {
      lights[region.pixels[i]] = region.lights[i];
    }
  }
  return lights;
}

Result<FlatField> FlatOf(const RigConfig& rig, const Calibrations& calibrations,
                         const std::vector<StoredFrame>& frames, const std::vector<float>& lights) {
  const SensorModel sensor = SensorModelOf(rig, calibrations);
  const auto per_pixel = static_cast<std::size_t>(CountsPerPixel(sensor.format.layout));
  std::vector<CorrectedFrame> corrected;
  for (const StoredFrame& stored : frames) {
    const auto dark = DarkOf(rig, calibrations, stored.frame);
    if (!dark) return dark.error();
    auto frame = Correct(sensor, stored.frame, stored.monitor, &*dark);
    if (!frame) return frame.error();
    for (std::size_t i = 0; i < frame->electrons.size(); ++i) {
      frame->electrons[i] /= lights[i / per_pixel];
    }
    corrected.push_back(std::move(frame).value());
  }
  return MeasureFlatField(corrected);
}

// One for each series of frames.
Result<std::vector<FlatField>> FlatsOf(const RigConfig& rig, const Calibrations& calibrations,
                                       const std::vector<std::vector<StoredFrame>>& frames,
                                       const std::vector<float>& lights) {
  std::vector<FlatField> flats;
  for (const std::vector<StoredFrame>& series : frames) {
    auto flat = FlatOf(rig, calibrations, series, lights);
    if (!flat) return flat.error();
    flats.push_back(std::move(flat).value());
  }
  return flats;
}

// A site that does not answer to one colour is bad for all.
BadPixels BadInAny(const SensorFormat& format, const DarkFit& dark,
                   const std::vector<FlatField>& flats) {
  BadPixels all = FindBadPixels(format, dark, flats.front().response);
  for (std::size_t k = 1; k < flats.size(); ++k) {
    const BadPixels more = FindBadPixels(format, dark, flats[k].response);
    for (std::size_t i = 0; i < all.mask.size(); ++i) {
      if ((more.mask[i] & kDeadPixel) != 0 && (all.mask[i] & kDeadPixel) == 0) ++all.dead;
      all.mask[i] |= more.mask[i];
    }
  }
  return all;
}

// Relative standard deviation of the response over the good sites, and the share that its own noise
// has in it.
std::pair<double, double> SpreadOf(const FlatField& flat) {
  double sum = 0, squares = 0, noise = 0, n = 0;
  for (std::size_t i = 0; i < flat.response.size(); ++i) {
    if (!std::isfinite(flat.sigma[i])) continue;
    sum += flat.response[i];
    squares += double{flat.response[i]} * flat.response[i];
    noise += double{flat.sigma[i]} * flat.sigma[i];
    n += 1;
  }
  const double mean = sum / n;
  return {std::sqrt(std::max(0.0, squares / n - mean * mean - noise / n)), std::sqrt(noise / n)};
}

}  // namespace

Result<StepReport> CalibrateDarks(const StepParts& parts, const StepOptions& options) {
  StepFrames step(parts, options, "darks");
  const RigConfig& rig = parts.rig;
  if (auto off = parts.devices.light->SetLevel(0); !off) return off.error();
  const int times = options.frames > 0 ? options.frames : kDarkFrames;
  const auto choose = [&]() -> Result<std::vector<double>> {
    const double longest = rig.camera.max_exposure.count();
    return Repeated({rig.camera.min_exposure.count(), longest / 10, longest}, times);
  };
  const auto frames = step.Take(false, "", choose);
  if (!frames) return frames.error();
  std::vector<Frame> raw;
  for (const StoredFrame& stored : *frames) raw.push_back(stored.frame);
  const auto library =
      MeasureDark(step.format(), raw, rig.radiometry.electrons_per_count, options.now);
  if (!library) return library.error();
  const BadPixels bad = FindBadPixels(step.format(), library->fits.front(), {});
  StepReport report;
  report.files = {step.FileOf(CalibrationKind::kBadPixels), step.FileOf(CalibrationKind::kDark)};
  WriteBadPixels(report.files[0], step.Stamp(*frames), bad);
  WriteDark(report.files[1], *library);
  step.Finish();
  for (const DarkFit& fit : library->fits) {
    report.lines.push_back(fmt::format(
        "darks            {} levels to {:.4g} s{}, noise {:.3f} counts", fit.levels.size(),
        fit.levels.back().exposure,
        frames->front().frame.temperature_c ? fmt::format(" at {:.1f} C", fit.temperature_c) : "",
        std::sqrt(fit.read_variance)));
  }
  report.lines.push_back(
      fmt::format("dark current     {:.4g} counts/s on average", MeanRate(*library)));
  report.lines.push_back(BadPixelsLine(bad));
  return report;
}

Result<StepReport> CalibratePhotonTransfer(const StepParts& parts, const StepOptions& options) {
  StepFrames step(parts, options, "photon-transfer");
  const Calibrations earlier = step.Earlier({CalibrationKind::kDark, CalibrationKind::kBadPixels});
  if (auto there = step.GoTo(step.Pose()); !there) return there.error();
  // Electrons are alike, whatever light freed them.
  if (auto lit = step.LightIn(step.BrightestColour()); !lit) return lit.error();
  const CameraInfo& camera = parts.rig.camera;
  const int times = options.frames > 0 ? options.frames + options.frames % 2 : kTransferFrames;
  const auto choose = [&]() -> Result<std::vector<double>> {
    const auto half = step.Meter(0.5);
    if (!half) return half.error();
    std::vector<double> exposures;
    for (const double level : TransferLevels()) {
      const double exposure =
          std::clamp(level / 0.5 * *half, camera.min_exposure.count(), camera.max_exposure.count());
      if (exposures.empty() || exposure > exposures.back()) exposures.push_back(exposure);
    }
    return Repeated(exposures, times);
  };
  auto frames = step.Take(true, "", choose);
  if (!frames) return frames.error();
  auto shortest = step.Take(true, "shortest", [&]() -> Result<std::vector<double>> {
    return Repeated({camera.min_exposure.count()}, std::max(times, kShortestFrames));
  });
  if (!shortest) return shortest.error();
  const CalibrationStamp stamp = step.Stamp(*frames);
  const auto series = EvaluateSeries(step, earlier, PairsOf(std::move(frames).value()),
                                     PairsOf(std::move(shortest).value()), times);
  if (!series) return series.error();
  StepReport report;
  report.files = {step.FileOf(CalibrationKind::kPhotonTransfer)};
  WriteSensor(report.files[0], stamp, series->sensor);
  step.Finish();
  report.lines = LinesOf(*series);
  return report;
}

Result<StepReport> CalibrateFlat(const StepParts& parts, const StepOptions& options) {
  StepFrames step(parts, options, "flat");
  Calibrations earlier = step.Earlier(
      {CalibrationKind::kDark, CalibrationKind::kBadPixels, CalibrationKind::kPhotonTransfer});
  if (auto there = step.GoTo(step.Pose()); !there) return there.error();
  const int times = options.frames > 0 ? options.frames : kFlatFrames;
  const auto choose = [&]() -> Result<std::vector<double>> {
    const auto exposure = step.Meter(parts.rig.exposure.target_fraction);
    if (!exposure) return exposure.error();
    return Repeated({*exposure}, times);
  };
  std::vector<std::vector<StoredFrame>> frames;  // of each colour
  for (const auto& colour : step.Turns()) {
    if (auto lit = step.LightIn(colour); !lit) return lit.error();
    auto taken = step.Take(true, "", choose);
    if (!taken) return taken.error();
    frames.push_back(std::move(taken).value());
  }
  const std::vector<float> lights = LightOnPixels(parts.rig, step);
  // Dead sites show in the flats only, and spoil the mean that all are compared with: twice.
  auto flats = FlatsOf(parts.rig, earlier, frames, lights);
  if (!flats) return flats.error();
  earlier.bad_pixels = BadInAny(step.format(), earlier.dark->fits.front(), *flats);
  flats = FlatsOf(parts.rig, earlier, frames, lights);
  if (!flats) return flats.error();
  StepReport report;
  report.files = {step.FileOf(CalibrationKind::kBadPixels),
                  step.FileOf(CalibrationKind::kFlatField)};
  const CalibrationStamp stamp = step.Stamp(frames.front());
  WriteBadPixels(report.files[0], stamp, *earlier.bad_pixels);
  if (flats->size() == 1) {
    WriteFlatField(report.files[1], stamp, flats->front());
  } else {
    ColourFlats colours;
    std::move(flats->begin(), flats->end(), colours.begin());
    WriteColourFlats(report.files[1], stamp, colours);
    flats->assign(colours.begin(), colours.end());
  }
  step.Finish();
  for (std::size_t i = 0; i < flats->size(); ++i) {
    const auto [spread, noise] = SpreadOf((*flats)[i]);
    report.lines.push_back(
        fmt::format("pattern          {}{:.2f} % from site to site, known to {:.2f} % each",
                    flats->size() == 1 ? "" : fmt::format("{:<5} ", kChannelNames[i]), 100 * spread,
                    100 * noise));
  }
  report.lines.push_back(BadPixelsLine(*earlier.bad_pixels));
  return report;
}

}  // namespace gonio
