// SPDX-License-Identifier: Apache-2.0
// Stray light and the standard: what is the instrument's as a whole.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "acquisition/calibration/step_frames.h"
#include "acquisition/radiometry/reference_standard.h"
#include "acquisition/region_rates.h"
#include "core/units.h"

namespace gonio {
namespace {

constexpr int kStrayFrames = 16;
constexpr int kStandardFrames = 8;
constexpr int kGlareFrames = 16;
// Of the trap's radius: beyond it the edge may be seen blurred.
constexpr double kInsideTrap = 0.7;
constexpr std::size_t kLeastTrapPixels = 20;
constexpr double kGlareLevel = 0.4;  // of full scale, for the mean of the image: no site saturates
// A certificate's point is met where the encoders are this near.
constexpr double kTolerance = RadFromDeg(0.5);

// The frames as those of a pose, for the reduction that sessions have.
PoseRecord RecordOf(const StepFrames& step, const Calibrations& calibrations,
                    const std::vector<StoredFrame>& frames) {
  PoseRecord record;
  record.regions = step.regions();
  if (calibrations.bad_pixels) {
    LeaveOut(calibrations.bad_pixels->mask, CountsPerPixel(step.format().layout), &record.regions);
  }
  for (const StoredFrame& stored : frames) {
    Exposure exposure;
    exposure.frame = stored.frame;
    exposure.monitor = stored.monitor;
    exposure.colour = stored.colour;
    record.exposures.push_back(std::move(exposure));
  }
  return record;
}

Result<RegionRates> RatesOf(const StepFrames& step, const Calibrations& calibrations,
                            const PoseRecord& record) {
  if (record.regions.empty()) return Error{ErrorCode::kRefused, "no good pixel sees the sample"};
  const auto rates = MeasureRates(record, step.rig(), calibrations);
  if (!rates) return rates.error();
  for (const RegionRate& rate : rates->front()) {
    if (!rate.measured) return Error{ErrorCode::kRefused, "a channel is saturated in every frame"};
  }
  return rates->front();
}

// Frames in all colours of the light, one series after the other.
Result<std::vector<StoredFrame>> TakeInColours(StepFrames& step, const std::string& part,
                                               const StepFrames::Choose& choose) {
  std::vector<StoredFrame> all;
  for (const auto& colour : step.Turns()) {
    if (auto lit = step.LightIn(colour); !lit) return lit.error();
    auto taken = step.Take(true, part, choose);
    if (!taken) return taken.error();
    std::move(taken->begin(), taken->end(), std::back_inserter(all));
  }
  return all;
}

// The standard in one pose: rate per f_r of each channel, by what differs from pose to pose.
struct StandardReading {
  std::array<MeasuredValue, kChannels> independent;
  std::array<double, kChannels> shared{};  // relative: certificate, flat, darks, ...
};

Result<StandardReading> ReadStandard(const StepFrames& step, const Calibrations& calibrations,
                                     const std::vector<StoredFrame>& frames,
                                     const ReferenceStandard& standard,
                                     const StandardPoint& point) {
  const auto rates = RatesOf(step, calibrations, RecordOf(step, calibrations, frames));
  if (!rates) return rates.error();
  StandardReading reading;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const RegionRate& rate = (*rates)[c];
    const auto f_r = standard.At(point.theta_i, point.theta_o, static_cast<int>(c), kTolerance);
    if (!f_r) return f_r.error();
    const auto one = ResponsivityFrom({rate.rate, rate.random()}, {f_r->value, 0});
    if (!one) return one.error();
    reading.independent[c] = *one;
    reading.shared[c] = std::hypot(f_r->relative(), rate.systematic() / rate.rate);
  }
  return reading;
}

// The certificate's points to measure: the one that the options name, or all in reach.
std::vector<StandardPoint> PointsOf(const ReferenceStandard& standard, const StepFrames& step) {
  const StepOptions& options = step.options();
  const Kinematics kinematics(step.rig());
  std::vector<StandardPoint> points;
  for (const StandardPoint& point : standard.points()) {
    const bool wanted =
        (!options.theta_i || std::abs(point.theta_i - *options.theta_i) < kTolerance) &&
        (!options.theta_o || std::abs(point.theta_o - *options.theta_o) < kTolerance);
    if (wanted && kinematics.Reachable(PairInPlane(point.theta_i, point.theta_o))) {
      points.push_back(point);
    }
  }
  return points;
}

std::string PartOf(const StandardPoint& point) {
  return fmt::format("at-{:.1f}-{:.1f}", DegFromRad(point.theta_i), DegFromRad(point.theta_o));
}

// All channels of all poses.
Responsivity JoinReadings(const std::vector<StandardReading>& readings, const std::string& name,
                          std::vector<std::string>* lines) {
  Responsivity result;
  result.standard = name;
  for (std::size_t c = 0; c < kChannels; ++c) {
    std::vector<MeasuredValue> independent;
    double shared = 0;
    for (const StandardReading& reading : readings) {
      independent.push_back(reading.independent[c]);
      shared = std::max(shared, reading.shared[c]);
    }
    const JoinedResponsivity joined = JoinResponsivities(independent, shared);
    result.responsivity[c] = joined.responsivity;
    lines->push_back(fmt::format(
        "responsivity     {:<5} {:.5g} +- {:.2g} electrons/s/(1/sr); poses: chi^2 {:.1f} of {}",
        kChannelNames[c], joined.responsivity.value, joined.responsivity.sigma, joined.chi_squared,
        joined.degrees_of_freedom));
  }
  return result;
}

// Pixels well inside the trap, and all of them: rates of both are then as they are, not per light.
Result<std::vector<ImageRegion>> TrapAndAll(const StepFrames& step, const Calibrations& earlier) {
  const RigConfig& rig = step.rig();
  Imaging inside = step.imaging();
  const double radius = step.options().trap_radius;
  inside.patch_radius = kInsideTrap * (radius > 0 ? radius : rig.imaging.patch_radius);
  std::vector<ImageRegion> regions =
      RegionsOf(inside, step.arms(), rig.camera.width, rig.camera.height, rig.geometry.max_polar);
  ImageRegion all;
  all.pixels.resize(static_cast<std::size_t>(rig.camera.width) * rig.camera.height);
  std::iota(all.pixels.begin(), all.pixels.end(), 0U);
  regions.push_back(std::move(all));
  for (ImageRegion& region : regions) {
    region.lights.clear();
    region.light = 1;
  }
  LeaveOut(earlier.bad_pixels->mask, CountsPerPixel(step.format().layout), &regions);
  if (regions.size() == 2 && regions[0].pixels.size() >= kLeastTrapPixels) return regions;
  return Error{ErrorCode::kRefused,
               fmt::format("fewer than {} pixels see the trap", kLeastTrapPixels)};
}

// g of one channel, from the trap's rate and that of the whole image.
Result<MeasuredValue> GlareOf(const RegionRate& trap, const RegionRate& all,
                              const MeasuredValue& background) {
  const auto net = [&](const RegionRate& rate) {
    return MeasuredValue{rate.rate - background.value,
                         std::hypot(rate.random(), rate.systematic())};
  };
  MeasuredValue dark = net(trap);
  dark.sigma = std::hypot(dark.sigma, background.sigma);
  return GlareFraction(dark, net(all));
}

}  // namespace

Result<StepReport> CalibrateStrayLight(const StepParts& parts, const StepOptions& options) {
  StepFrames step(parts, options, "stray-light");
  Calibrations earlier = step.Earlier(
      {CalibrationKind::kDark, CalibrationKind::kPhotonTransfer, CalibrationKind::kFlatField});
  const std::optional<StrayLights> before = earlier.stray;  // glare is the lens's, and stays
  earlier.stray.reset();  // what is measured is not taken off before
  if (auto there = step.GoTo(step.Pose()); !there) return there.error();
  const int times = options.frames > 0 ? options.frames : kStrayFrames;
  const auto choose = [&]() -> Result<std::vector<double>> {
    const auto exposure = step.Meter(parts.rig.exposure.target_fraction);
    if (!exposure) return exposure.error();
    const double limit =
        std::max(parts.rig.exposure.soft_limit.count(), parts.rig.camera.min_exposure.count());
    return Repeated({std::min(*exposure, limit)}, times);
  };
  const auto frames = TakeInColours(step, "", choose);
  if (!frames) return frames.error();
  const PoseRecord record = RecordOf(step, earlier, *frames);
  const auto rates = RatesOf(step, earlier, record);
  if (!rates) return rates.error();
  StepReport report;
  StrayLights stray;
  const double light = record.regions.front().light;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const RegionRate& rate = (*rates)[c];
    if (before) stray[c].glare = (*before)[c].glare;
    stray[c].background = {rate.rate * light, light * std::hypot(rate.random(), rate.systematic())};
    report.lines.push_back(fmt::format("background       {:<5} {:.4g} +- {:.2g} electrons/s",
                                       kChannelNames[c], stray[c].background.value,
                                       stray[c].background.sigma));
  }
  report.files = {step.FileOf(CalibrationKind::kStrayLight)};
  WriteStrayLight(report.files[0], step.Stamp(*frames), stray);
  step.Finish();
  return report;
}

Result<StepReport> CalibrateGlare(const StepParts& parts, const StepOptions& options) {
  if (!parts.rig.imaging.resolves_directions()) {
    throw ConfigError("without `imaging` in the rig file no pixel is known to see the trap");
  }
  StepFrames step(parts, options, "glare");
  Calibrations earlier = step.Earlier({CalibrationKind::kDark, CalibrationKind::kPhotonTransfer,
                                       CalibrationKind::kBadPixels, CalibrationKind::kFlatField,
                                       CalibrationKind::kStrayLight});
  StrayLights stray = *earlier.stray;
  earlier.stray.reset();  // taken off here, without the glare that is looked for
  if (auto there = step.GoTo(step.Pose()); !there) return there.error();
  auto regions = TrapAndAll(step, earlier);
  if (!regions) return regions.error();
  step.LookAt({regions->back()});
  const int times = options.frames > 0 ? options.frames : kGlareFrames;
  const auto choose = [&]() -> Result<std::vector<double>> {
    const auto exposure = step.Meter(kGlareLevel);
    if (!exposure) return exposure.error();
    return Repeated({*exposure}, times);
  };
  const auto frames = TakeInColours(step, "", choose);
  if (!frames) return frames.error();
  PoseRecord record = RecordOf(step, earlier, *frames);
  record.regions = std::move(*regions);
  const auto rates = MeasureRates(record, parts.rig, earlier);
  if (!rates) return rates.error();
  StepReport report;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const RegionRate& all = rates->back()[c];
    if (!all.measured) return Error{ErrorCode::kRefused, "some of the tile is saturated"};
    const auto glare = GlareOf(rates->front()[c], all, stray[c].background);
    if (!glare) return glare.error();
    stray[c].glare = *glare;
    report.lines.push_back(
        fmt::format("glare            {:<5} {:.3f} +- {:.2g} % of the image's mean",
                    kChannelNames[c], 100 * glare->value, 100 * glare->sigma));
  }
  // The file is as old as its background.
  report.files = {step.FileOf(CalibrationKind::kStrayLight)};
  const CalibrationHeader header = ReadCalibrationHeader(report.files[0]);
  WriteStrayLight(report.files[0],
                  {header.created, step.format(), header.temperature_c, header.light}, stray);
  step.Finish();
  return report;
}

Result<StepReport> CalibrateStandard(const StepParts& parts, const StepOptions& options) {
  if (options.standard.empty()) throw ConfigError("the standard's file is needed: --standard");
  const ReferenceStandard standard = ReferenceStandard::Load(options.standard);
  StepFrames step(parts, options, "standard");
  const Calibrations earlier = step.Earlier(
      {CalibrationKind::kDark, CalibrationKind::kPhotonTransfer, CalibrationKind::kFlatField});
  const std::vector<StandardPoint> points = PointsOf(standard, step);
  if (points.empty()) {
    return Error{ErrorCode::kRefused,
                 options.standard.string() + ": has no such point in reach of the arms"};
  }
  const int times = options.frames > 0 ? options.frames : kStandardFrames;
  const auto choose = [&]() -> Result<std::vector<double>> {
    const auto exposure = step.Meter(parts.rig.exposure.target_fraction);
    if (!exposure) return exposure.error();
    return Repeated({*exposure}, times);
  };
  StepReport report;
  std::vector<StandardReading> readings;
  std::vector<StoredFrame> last;
  for (const StandardPoint& point : points) {
    if (auto there = step.GoTo(PairInPlane(point.theta_i, point.theta_o)); !there) {
      return there.error();
    }
    auto frames = TakeInColours(step, PartOf(point), choose);
    if (!frames) return frames.error();
    auto reading = ReadStandard(step, earlier, *frames, standard, point);
    if (!reading) return reading.error();
    readings.push_back(std::move(reading).value());
    last = std::move(frames).value();
  }
  report.lines = {fmt::format("standard         {}, {} poses{}", standard.name(), points.size(),
                              earlier.stray ? "" : "; no stray light taken off")};
  const Responsivity responsivity = JoinReadings(readings, standard.name(), &report.lines);
  report.files = {step.FileOf(CalibrationKind::kResponsivity)};
  WriteResponsivity(report.files[0], step.Stamp(last), responsivity);
  step.Finish();
  return report;
}

}  // namespace gonio
