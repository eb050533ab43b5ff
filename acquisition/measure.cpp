// SPDX-License-Identifier: Apache-2.0
#include "acquisition/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "core/units.h"
#include "drivers/move_time.h"

namespace gonio {
namespace {

// White paper [1/sr]: what to expect of the first pose if nobody knows. A frame that comes out too
// dark still says how dark; one that saturates says little.
constexpr double kUnknownReflectance = 0.3;

// Whether the frame says nothing of any channel it is for.
bool SaysNothing(const Exposure& e) {
  if (e.colour) return e.saturated[static_cast<std::size_t>(ChannelOf(*e.colour))];
  return std::all_of(e.saturated.begin(), e.saturated.end(),
                     [](bool saturated) { return saturated; });
}

bool Saturated(const Exposure& e) {
  return std::any_of(e.saturated.begin(), e.saturated.end(),
                     [](bool saturated) { return saturated; });
}

// The longest exposure that saturated nothing: a good start for a similar pose.
std::optional<Seconds> Suited(std::span<const Exposure> exposures) {
  std::optional<Seconds> suited;
  for (const Exposure& e : exposures) {
    if (!Saturated(e) && (!suited || e.frame.exposure > *suited)) suited = e.frame.exposure;
  }
  return suited;
}

bool AllSayNothing(std::span<const Exposure> exposures) {
  return std::all_of(exposures.begin(), exposures.end(), SaysNothing);
}

// Where encoders read so: an axis that stands at the end of its range reads beyond it as often as
// not, and must not be told to go there.
AxisPositions WithinTargets(const RigConfig& rig, AxisPositions angles) {
  for (int i = 0; i < rig.axis_count; ++i) {
    const AxisLimits limits = TargetLimits(rig.axes[i]);
    const double inside = std::clamp(angles[i], limits.min_position, limits.max_position);
    if (std::abs(angles[i] - inside) <= rig.axes[i].position_tolerance) angles[i] = inside;
  }
  return angles;
}

}  // namespace

std::vector<ImageRegion> RegionsSeen(const RigConfig& rig, const Kinematics& kinematics,
                                     const AxisPositions& readback, const SiteMask* bad) {
  std::vector<ImageRegion> regions =
      RegionsOf(kinematics.ImagingAt(rig.imaging, readback), kinematics.TrueAngles(readback),
                rig.camera.width, rig.camera.height, rig.geometry.max_polar, rig.samples_per_image);
  if (bad != nullptr) LeaveOut(*bad, CountsPerPixel(rig.camera.layout), &regions);
  return regions;
}

PoseMeasurer::PoseMeasurer(const RigConfig& rig, Devices& devices, Clock& clock,
                           const SiteMask* bad)
    : rig_(rig),
      devices_(devices),
      clock_(clock),
      bad_(bad),
      taker_(rig, devices),
      colours_(rig, devices, clock),
      paths_(rig) {}

Result<void> PoseMeasurer::Prepare(std::stop_token stop) {
  axes_failed_ = true;
  if (auto homed = HomeAll(rig_.motion, devices_, stop); !homed) return homed;
  if (auto lit = SwitchOn(stop); !lit) return lit;
  axes_failed_ = true;
  const auto position = ReadPositions(devices_);
  if (!position) return position.error();
  position_ = *position;
  state_ = {.told = position_, .exposure = {}};
  // The mark may be beyond what an axis may be told.
  for (int i = 0; i < rig_.axis_count; ++i) {
    const AxisLimits limits = TargetLimits(rig_.axes[i]);
    state_.told[i] = std::clamp(position_[i], limits.min_position, limits.max_position);
  }
  return {};
}

Result<void> PoseMeasurer::SwitchOn(std::stop_token stop) {
  axes_failed_ = false;
  if (auto lit = devices_.light->SetLevel(rig_.light_level); !lit) return lit;
  colours_.Forget();  // light and monitor may be opened anew
  if (const auto first = ColoursInTurn(rig_).front()) {
    if (auto selected = colours_.Select(*first, std::move(stop)); !selected) return selected;
  }
  return taker_.CheckSteady(clock_);
}

Result<PoseRecord> PoseMeasurer::Measure(const DirectionPair& pair,
                                         const std::optional<Rgb>& expected, std::stop_token stop,
                                         int frames) {
  return MeasureOrStop([&] { return paths_.PlanTo(position_, pair); }, expected, std::move(stop),
                       frames);
}

Result<PoseRecord> PoseMeasurer::MeasureAt(const AxisPositions& arms,
                                           const std::optional<Rgb>& expected, std::stop_token stop,
                                           int frames) {
  return MeasureOrStop([&] { return paths_.Plan(position_, arms); }, expected, std::move(stop),
                       frames);
}

Result<void> PoseMeasurer::Restore(const MeasurerState& state, std::stop_token stop) {
  if (auto moved = GoTo(state.told, std::move(stop)); !moved) return moved;
  state_.exposure = state.exposure;
  state_.rates = state.rates;
  state_.colour = state.colour;
  return {};
}

Result<void> PoseMeasurer::GoTo(const AxisPositions& arms, std::stop_token stop) {
  PoseRecord record;
  return Move([&] { return paths_.Plan(position_, arms); }, record, std::move(stop));
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
  if (auto exposed = Expose(expected, frames, record, stop); !exposed) return exposed.error();
  if (auto stood = CheckStood(record.readback); !stood) return stood.error();
  record.end = clock_.Now();
  return record;
}

// Whether the arms are still where they were when the first frame was taken: a motor without power
// lets go, and a controller that was reset no longer knows.
Result<void> PoseMeasurer::CheckStood(const AxisPositions& readback) {
  axes_failed_ = true;
  const auto now = ReadPositions(devices_);
  if (!now) return now.error();
  for (int i = 0; i < rig_.axis_count; ++i) {
    const double moved = (*now)[i] - readback[i];
    if (std::abs(moved) <= rig_.axes[i].position_tolerance) continue;
    return Error{ErrorCode::kProtocol,
                 fmt::format("{}: has moved by {:.4f} deg while frames were taken",
                             devices_.axes[i]->name(), DegFromRad(moved))};
  }
  axes_failed_ = false;
  return {};
}

Result<void> PoseMeasurer::Move(const FindPath& find, PoseRecord& record, std::stop_token stop) {
  axes_failed_ = true;
  const auto before = ReadPositions(devices_);
  if (!before) return before.error();
  position_ = WithinTargets(rig_, *before);
  const auto path = find();
  if (!path) return path.error();
  record.commanded = path->back();
  for (const AxisPositions& leg : *path) {
    for (int i = 0; i < kAxes; ++i) {
      if (!Stays(position_[i] - leg[i], rig_.axes[i])) state_.told[i] = leg[i];
    }
  }
  const auto arrival = MoveAlong(rig_, devices_, clock_, *path, stop);
  if (!arrival) return arrival.error();
  position_ = record.readback = arrival->readback;
  record.move_retries = arrival->retries;
  record.move_time = arrival->still - record.start;
  axes_failed_ = false;
  return {};
}

Result<void> PoseMeasurer::Expose(const std::optional<Rgb>& expected, int frames,
                                  PoseRecord& record, std::stop_token stop) {
  Turn turn;
  bool more = false;
  for (const std::optional<LightColour>& colour : ColoursInTurn(rig_, state_.colour)) {
    turn.colour = colour;
    turn.begin = record.exposures.size();
    if (colour) {
      if (auto selected = colours_.Select(*colour, stop); !selected) return selected;
      state_.colour = colour;
    }
    const auto exposed = ExposeUntilUsable(expected, turn, record, stop);
    if (!exposed) return exposed.error();
    more = more || *exposed;
    if (auto repeated = RepeatSuited(frames, turn, record, stop); !repeated) return repeated;
  }
  if (!AllSayNothing(record.exposures)) return {};
  return Error{ErrorCode::kRefused,
               more ? fmt::format("saturated in all {} frames", record.exposures.size())
                    : "saturated at the shortest exposure"};
}

// Counts per second of each channel.
Rgb PoseMeasurer::Predicted(const std::optional<Rgb>& expected, double monitor,
                            const PoseRecord& record) const {
  const Rgb f_r = expected.value_or(Rgb::Constant(kUnknownReflectance));
  Rgb rates = CountRates(f_r, record.regions.front().light, monitor, rig_.radiometry);
  for (int c = 0; !expected && c < kChannels; ++c) {
    rates[c] = state_.rates[static_cast<std::size_t>(c)].value_or(rates[c]);
  }
  return rates;
}

Seconds PoseMeasurer::FirstOf(const std::optional<Rgb>& expected, const Turn& turn, double monitor,
                              const PoseRecord& record) const {
  const Rgb rates = Predicted(expected, monitor, record);
  if (turn.colour) {
    Rgb own = Rgb::Zero();
    own[ChannelOf(*turn.colour)] = turn.lift * rates[ChannelOf(*turn.colour)];
    return FirstExposure(own, rig_);
  }
  if (!expected && state_.exposure) return std::min(*state_.exposure, rig_.exposure.soft_limit);
  return FirstExposure(rates, rig_);
}

Result<bool> PoseMeasurer::ExposeUntilUsable(const std::optional<Rgb>& expected, Turn& turn,
                                             PoseRecord& record, std::stop_token stop) {
  auto monitor = taker_.ReadMonitor();
  if (!monitor) return monitor.error();
  const Rgb predicted = Predicted(expected, *monitor, record);
  std::optional<Seconds> next = FirstOf(expected, turn, *monitor, record);
  const auto taken = [&] { return std::span(record.exposures).subspan(turn.begin); };
  while (next && std::ssize(taken()) < rig_.exposure.max_frames) {
    if (!taken().empty()) monitor = taker_.ReadMonitor();
    if (!monitor) return monitor.error();
    if (auto added = AddExposure(*next, *monitor, turn, record, stop); !added) return added.error();
    next = NextExposure(taken(), record.regions, rig_);
  }
  Learn(predicted, turn, record);
  return next.has_value();
}

// For the colours that follow, and the next pose.
void PoseMeasurer::Learn(const Rgb& predicted, Turn& turn, const PoseRecord& record) {
  const auto taken = std::span(record.exposures).subspan(turn.begin);
  if (!turn.colour) {
    if (AllSayNothing(taken)) {
      state_.exposure = rig_.camera.min_exposure;
    } else if (const auto suited = Suited(taken)) {
      state_.exposure = suited;
    }
    return;
  }
  const int c = ChannelOf(*turn.colour);
  // What saturates the shortest exposure is at least as bright as that.
  const double brightest = rig_.camera.full_scale / rig_.camera.min_exposure.count();
  const double rate = RateOf(taken, record.regions, c, rig_).value_or(brightest);
  state_.rates[static_cast<std::size_t>(c)] = rate;
  if (predicted[c] > 0 && std::isfinite(predicted[c])) turn.lift = rate / predicted[c];
}

Result<void> PoseMeasurer::RepeatSuited(int frames, const Turn& turn, PoseRecord& record,
                                        std::stop_token stop) {
  const auto taken = [&] { return std::span(record.exposures).subspan(turn.begin); };
  const auto suited = Suited(taken());
  for (int n = 1; suited && n < frames; ++n) {
    if (std::ssize(taken()) >= rig_.exposure.max_frames) break;
    const auto monitor = taker_.ReadMonitor();
    if (!monitor) return monitor.error();
    if (auto added = AddExposure(*suited, *monitor, turn, record, stop); !added) return added;
  }
  return {};
}

Result<void> PoseMeasurer::AddExposure(Seconds exposure, double monitor, const Turn& turn,
                                       PoseRecord& record, std::stop_token stop) {
  auto taken = taker_.Take(exposure, monitor, std::move(stop));
  if (!taken) return taken.error();
  taken->colour = turn.colour;
  const FrameMeans means =
      MeansOf(taken->frame, rig_.camera.full_scale, record.regions, turn.colour);
  for (int c = 0; c < kChannels; ++c) taken->saturated[c] = means.saturated_fraction[c] > 0;
  record.exposures.push_back(std::move(taken).value());
  return {};
}

}  // namespace gonio
