// SPDX-License-Identifier: Apache-2.0
#include "acquisition/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "drivers/move_time.h"

namespace gonio {
namespace {

// White paper [1/sr]: what to expect of the first pose if nobody knows. A frame that comes out too
// dark still says how dark; one that saturates says little.
constexpr double kUnknownReflectance = 0.3;

// How many channels are saturated.
int Saturated(const Exposure& e) {
  return static_cast<int>(std::count(e.saturated.begin(), e.saturated.end(), true));
}

// The longest exposure that saturated nothing: a good start for a similar pose.
std::optional<Seconds> Suited(const std::vector<Exposure>& exposures) {
  std::optional<Seconds> suited;
  for (const Exposure& e : exposures) {
    if (Saturated(e) == 0 && (!suited || e.frame.exposure > *suited)) suited = e.frame.exposure;
  }
  return suited;
}

bool AllSaturated(const std::vector<Exposure>& exposures) {
  return std::all_of(exposures.begin(), exposures.end(),
                     [](const Exposure& e) { return Saturated(e) == kChannels; });
}

}  // namespace

std::vector<ImageRegion> RegionsSeen(const RigConfig& rig, const Kinematics& kinematics,
                                     const ArmAngles& readback, const SiteMask* bad) {
  std::vector<ImageRegion> regions =
      RegionsOf(kinematics.ImagingAt(rig.imaging, readback), kinematics.TrueAngles(readback),
                rig.camera.width, rig.camera.height, rig.geometry.max_polar, rig.samples_per_image);
  if (bad != nullptr) LeaveOut(*bad, CountsPerPixel(rig.camera.layout), &regions);
  return regions;
}

PoseMeasurer::PoseMeasurer(const RigConfig& rig, Devices& devices, Clock& clock,
                           const SiteMask* bad)
    : rig_(rig), devices_(devices), clock_(clock), bad_(bad), taker_(rig, devices), paths_(rig) {}

Result<void> PoseMeasurer::Prepare(std::stop_token stop) {
  if (auto homed = HomeAll(rig_.motion, devices_, stop); !homed) return homed;
  if (auto lit = devices_.light->SetLevel(rig_.light_level); !lit) return lit;
  const auto position = ReadPositions(devices_);
  if (!position) return position.error();
  position_ = *position;
  state_ = {.told = position_, .exposure = {}};
  return {};
}

Result<PoseRecord> PoseMeasurer::Measure(const DirectionPair& pair,
                                         const std::optional<Rgb>& expected, std::stop_token stop,
                                         int frames) {
  return MeasureOrStop([&] { return paths_.PlanTo(position_, pair); }, expected, std::move(stop),
                       frames);
}

Result<PoseRecord> PoseMeasurer::MeasureAt(const ArmAngles& arms,
                                           const std::optional<Rgb>& expected, std::stop_token stop,
                                           int frames) {
  return MeasureOrStop([&] { return paths_.Plan(position_, arms); }, expected, std::move(stop),
                       frames);
}

Result<void> PoseMeasurer::Restore(const MeasurerState& state, std::stop_token stop) {
  PoseRecord record;
  const FindPath find = [&] { return paths_.Plan(position_, state.told); };
  if (auto moved = Move(find, record, std::move(stop)); !moved) return moved;
  state_.exposure = state.exposure;
  return {};
}

Result<PoseRecord> PoseMeasurer::MeasureOrStop(const FindPath& find,
                                               const std::optional<Rgb>& expected,
                                               std::stop_token stop, int frames) {
  auto record = MeasureOrFail(find, expected, stop, frames);
  // The first error is the one to report; stopping may fail for the same reason.
  if (!record && record.error().code != ErrorCode::kRefused) (void)StopAll(devices_);
  return record;
}

Result<PoseRecord> PoseMeasurer::MeasureOrFail(const FindPath& find,
                                               const std::optional<Rgb>& expected,
                                               std::stop_token stop, int frames) {
  PoseRecord record;
  record.start = clock_.Now();
  if (auto moved = Move(find, record, stop); !moved) return moved.error();
  record.regions = RegionsSeen(rig_, paths_.kinematics(), record.readback, bad_);
  if (record.regions.empty()) {
    return Error{ErrorCode::kRefused, "no pixel sees the sample lit and below max_polar_deg"};
  }
  if (auto exposed = ExposeUntilUsable(expected, record, stop); !exposed) return exposed.error();
  if (auto repeated = RepeatSuited(frames, record, stop); !repeated) return repeated.error();
  record.end = clock_.Now();
  return record;
}

Result<void> PoseMeasurer::Move(const FindPath& find, PoseRecord& record, std::stop_token stop) {
  const auto before = ReadPositions(devices_);
  if (!before) return before.error();
  position_ = *before;
  const auto path = find();
  if (!path) return path.error();
  record.commanded = path->back();
  for (const ArmAngles& leg : *path) {
    for (int i = 0; i < kAxes; ++i) {
      if (!Stays(position_[i] - leg[i], rig_.axes[i])) state_.told[i] = leg[i];
    }
  }
  const auto arrival = MoveAlong(rig_, devices_, clock_, *path, stop);
  if (!arrival) return arrival.error();
  position_ = record.readback = arrival->readback;
  record.move_retries = arrival->retries;
  record.move_time = arrival->still - record.start;
  return {};
}

Result<void> PoseMeasurer::ExposeUntilUsable(const std::optional<Rgb>& expected, PoseRecord& record,
                                             std::stop_token stop) {
  auto monitor = taker_.ReadMonitor();
  if (!monitor) return monitor.error();
  const double cos_theta_i = record.regions.front().light;
  const Rgb f_r = expected.value_or(Rgb::Constant(kUnknownReflectance));
  std::optional<Seconds> next =
      FirstExposure(CountRates(f_r, cos_theta_i, *monitor, rig_.radiometry), rig_);
  if (!expected && state_.exposure) next = std::min(*state_.exposure, rig_.exposure.soft_limit);

  while (next && std::ssize(record.exposures) < rig_.exposure.max_frames) {
    if (!record.exposures.empty()) monitor = taker_.ReadMonitor();
    if (!monitor) return monitor.error();
    if (auto added = AddExposure(*next, *monitor, record, stop); !added) return added;
    next = NextExposure(record.exposures, record.regions, rig_);
  }
  if (AllSaturated(record.exposures)) {
    state_.exposure = rig_.camera.min_exposure;
    return Error{ErrorCode::kRefused,
                 next ? fmt::format("saturated in all {} frames", record.exposures.size())
                      : "saturated at the shortest exposure"};
  }
  if (const auto suited = Suited(record.exposures)) state_.exposure = suited;
  return {};
}

Result<void> PoseMeasurer::RepeatSuited(int frames, PoseRecord& record, std::stop_token stop) {
  const auto suited = Suited(record.exposures);
  for (int n = 1; suited && n < frames; ++n) {
    if (std::ssize(record.exposures) >= rig_.exposure.max_frames) break;
    const auto monitor = taker_.ReadMonitor();
    if (!monitor) return monitor.error();
    if (auto added = AddExposure(*suited, *monitor, record, stop); !added) return added;
  }
  return {};
}

Result<void> PoseMeasurer::AddExposure(Seconds exposure, double monitor, PoseRecord& record,
                                       std::stop_token stop) {
  auto taken = taker_.Take(exposure, monitor, std::move(stop));
  if (!taken) return taken.error();
  const FrameMeans means = MeansOf(taken->frame, rig_.camera.full_scale, record.regions);
  for (int c = 0; c < kChannels; ++c) taken->saturated[c] = means.saturated_fraction[c] > 0;
  record.exposures.push_back(std::move(taken).value());
  return {};
}

}  // namespace gonio
