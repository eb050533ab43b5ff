// SPDX-License-Identifier: Apache-2.0
#include "acquisition/calibration/step_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "acquisition/exposure.h"
#include "acquisition/motion.h"
#include "core/units.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

constexpr double kDefaultThetaI = 45;  // degrees; with the camera at the normal
constexpr double kWhite = 0.3;         // 1/sr: what metering begins with
constexpr int kMeteringFrames = 15;
// A few hot pixels are no reason to expose shorter.
constexpr double kFewSaturated = 0.01;

}  // namespace

StepFrames::StepFrames(const StepParts& parts, const StepOptions& options, std::string step)
    : parts_(parts),
      options_(options),
      step_(std::move(step)),
      format_(SensorFormatOf(parts.rig, parts.devices.camera->identity())),
      taker_(parts.rig, parts.devices),
      colours_(parts.rig, parts.devices, parts.clock),
      paths_(parts.rig) {
  fs::create_directories(options.folder);
}

StepFrames::~StepFrames() { (void)parts_.devices.light->SetLevel(0).ok(); }

Calibrations StepFrames::Earlier(std::vector<CalibrationKind> needed) const {
  CalibrationPolicy policy;
  policy.folder = options_.folder;
  policy.max_age = std::numeric_limits<double>::infinity();
  for (const CalibrationKind kind : needed) {
    if (fs::exists(FileOf(kind))) continue;
    throw ConfigError(fmt::format("{}: has no {}, which this step needs; {} makes it",
                                  options_.folder.string(), FileNameOf(kind), CommandFor(kind)));
  }
  return LoadCalibrations(policy, format_, options_.now,
                          LightFormatOf(parts_.rig, *parts_.devices.light));
}

std::optional<LightColour> StepFrames::BrightestColour() const {
  if (!parts_.rig.by_colour) return std::nullopt;
  Eigen::Index brightest = 0;
  parts_.rig.radiometry.responsivity.maxCoeff(&brightest);
  return kLightColours[brightest];
}

Result<void> StepFrames::LightIn(const std::optional<LightColour>& colour) {
  colour_ = colour;
  return colour ? colours_.Select(*colour, options_.stop) : Result<void>();
}

DirectionPair StepFrames::Pose() const {
  return PairInPlane(options_.theta_i.value_or(RadFromDeg(kDefaultThetaI)),
                     options_.theta_o.value_or(0));
}

Result<void> StepFrames::GoTo(const DirectionPair& pair) {
  if (!prepared_) {
    if (auto homed = HomeAll(parts_.rig.motion, parts_.devices, options_.stop); !homed)
      return homed;
    if (auto lit = parts_.devices.light->SetLevel(parts_.rig.light_level); !lit) return lit;
    prepared_ = true;
  }
  const auto from = ReadPositions(parts_.devices);
  if (!from) return from.error();
  const auto path = paths_.PlanTo(*from, pair);
  if (!path) {
    return Error{path.error().code,
                 fmt::format("light at {:.1f}, camera at {:.1f} degrees from the normal: {}",
                             DegFromRad(std::acos(pair.cos_theta_i())),
                             DegFromRad(std::acos(pair.cos_theta_o())), path.error().message)};
  }
  const auto arrival = MoveAlong(parts_.rig, parts_.devices, parts_.clock, *path, options_.stop);
  if (!arrival) return arrival.error();
  arms_ = paths_.kinematics().TrueAngles(arrival->readback);
  imaging_ = paths_.kinematics().ImagingAt(parts_.rig.imaging, arrival->readback);
  const CameraInfo& camera = parts_.rig.camera;
  regions_ = RegionsOf(imaging_, arms_, camera.width, camera.height, parts_.rig.geometry.max_polar);
  if (regions_.empty()) return Error{ErrorCode::kRefused, "no pixel sees the sample lit"};
  return {};
}

Result<double> StepFrames::Meter(double fraction) {
  const RigConfig& rig = parts_.rig;
  const double shortest = rig.camera.min_exposure.count();
  const double longest = rig.camera.max_exposure.count();
  double exposure = FirstExposure(CountRates(Rgb::Constant(kWhite), regions_.front().light,
                                             rig.light_level, rig.radiometry),
                                  rig)
                        .count();
  for (int n = 0; n < kMeteringFrames; ++n) {
    const auto taken = TakeOne(exposure, true);
    if (!taken) return taken.error();
    const FrameMeans means = MeansOf(taken->frame, rig.camera.full_scale, regions_, colour_);
    const double level = means.counts.maxCoeff() / rig.camera.full_scale;
    const bool saturated = means.saturated_fraction.maxCoeff() > kFewSaturated;
    if (!saturated && level > 0.8 * fraction && level < 1.25 * fraction) break;
    const double factor =
        saturated ? 0.25 : std::clamp(fraction / std::max(level, 1e-6), 1.0 / 16, 16.0);
    const double next = std::clamp(exposure * factor, shortest, longest);
    if (next == exposure) break;
    exposure = next;
  }
  return exposure;
}

Result<std::vector<StoredFrame>> StepFrames::Take(bool lit, const std::string& part,
                                                  const Choose& choose) {
  const std::string name = PartOf(lit, part);
  FrameStore store(FramesFolder() / name, format_, Settings(lit), options_.again);
  if (store.exposures().empty()) {
    auto chosen = choose();
    if (!chosen) return chosen.error();
    store.FixExposures(std::move(chosen).value());
  }
  const std::vector<double>& exposures = store.exposures();
  const int total = static_cast<int>(exposures.size());
  std::vector<StoredFrame> frames;
  for (std::size_t i = 0; i < exposures.size(); ++i) {
    auto stored = store.Read(i);
    if (!stored) {
      auto taken = TakeOne(exposures[i], lit);
      if (!taken) return taken.error();
      store.Write(i, *taken);
      stored = std::move(taken).value();
    }
    frames.push_back(std::move(*stored));
    if (options_.progress) {
      options_.progress(static_cast<int>(i) + 1, total, name.empty() ? step_ : step_ + " " + name);
    }
  }
  return frames;
}

std::string StepFrames::PartOf(bool lit, const std::string& part) const {
  if (!lit || !colour_) return part;
  return part.empty() ? ToString(*colour_) : part + "-" + ToString(*colour_);
}

Result<StoredFrame> StepFrames::TakeOne(double exposure, bool lit) {
  if (options_.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped by the user"};
  StoredFrame stored;
  if (!lit) {
    auto frame = taker_.TakeDark(Seconds(exposure), options_.stop);
    if (!frame) return frame.error();
    stored.frame = std::move(frame).value();
    return stored;
  }
  const auto monitor = taker_.ReadMonitor();
  if (!monitor) return monitor.error();
  auto taken = taker_.Take(Seconds(exposure), *monitor, options_.stop);
  if (!taken) return taken.error();
  stored.frame = std::move(taken->frame);
  stored.monitor = taken->monitor;
  stored.colour = colour_;
  return stored;
}

FrameStore::Settings StepFrames::Settings(bool lit) const {
  FrameStore::Settings settings;
  settings["step"] = step_;
  settings["camera"] = format_.camera;
  settings["region_px"] =
      fmt::format("{}, {}, {}, {}", format_.left, format_.top, format_.width, format_.height);
  settings["pixel_layout"] = ToString(format_.layout);
  settings["gain_db"] = fmt::format("{:.4g}", format_.gain_db);
  settings["frames"] = std::to_string(options_.frames);
  settings["light_level"] = fmt::format("{:.4g}", lit ? parts_.rig.light_level : 0);
  if (!lit) return settings;
  if (parts_.rig.by_colour) settings["light"] = LightFormatOf(parts_.rig, *parts_.devices.light);
  const auto degrees = [](const std::optional<double>& angle) {
    return angle ? fmt::format("{:.4g}", DegFromRad(*angle)) : std::string("default");
  };
  settings["theta_i_deg"] = degrees(options_.theta_i);
  settings["theta_o_deg"] = degrees(options_.theta_o);
  if (options_.trap_radius > 0)
    settings["trap_radius_m"] = fmt::format("{:.6g}", options_.trap_radius);
  if (!options_.standard.empty()) settings["standard"] = fs::absolute(options_.standard).string();
  return settings;
}

fs::path StepFrames::FramesFolder() const { return options_.folder / (step_ + ".frames"); }

void StepFrames::Finish() const {
  if (!options_.keep_frames) fs::remove_all(FramesFolder());
}

fs::path StepFrames::FileOf(CalibrationKind kind) const {
  return options_.folder / FileNameOf(kind);
}

CalibrationStamp StepFrames::Stamp(const std::vector<StoredFrame>& frames) const {
  CalibrationStamp stamp{options_.now, format_, std::nullopt,
                         LightFormatOf(parts_.rig, *parts_.devices.light)};
  double sum = 0;
  for (const StoredFrame& stored : frames) {
    if (!stored.frame.temperature_c) return stamp;
    sum += *stored.frame.temperature_c;
  }
  if (!frames.empty()) stamp.temperature_c = sum / static_cast<double>(frames.size());
  return stamp;
}

DirectionPair PairInPlane(double theta_i, double theta_o) {
  return {FromSpherical(theta_i, 0), FromSpherical(theta_o, kPi)};
}

std::vector<double> Repeated(const std::vector<double>& exposures, int times) {
  std::vector<double> all;
  for (const double exposure : exposures)
    all.insert(all.end(), static_cast<std::size_t>(times), exposure);
  return all;
}

}  // namespace gonio
