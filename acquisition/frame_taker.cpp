// SPDX-License-Identifier: Apache-2.0
#include "acquisition/frame_taker.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace gonio {
namespace {

// A monitor below this fraction of the level that was set means that the light is out.
constexpr double kLightIsOut = 0.1;

bool WholeFrame(const Frame& frame, const CameraInfo& info) {
  return frame.width == info.width && frame.height == info.height && frame.layout == info.layout &&
         frame.exposure > Seconds::zero() && frame.counts.size() == info.counts();
}

Result<Frame> TakeWhole(Camera& camera, const CameraInfo& info, Seconds exposure,
                        std::stop_token stop) {
  auto frame = camera.Capture(exposure, std::move(stop));
  if (!frame || WholeFrame(*frame, info)) return frame;
  return Error{
      ErrorCode::kProtocol,
      fmt::format("{}: sent {} counts for a frame of {} x {} {}, expected {} x {} {}",
                  camera.name(), frame->counts.size(), frame->width, frame->height,
                  ToString(frame->layout), info.width, info.height, ToString(info.layout))};
}

// Precondition: there are some.
double Rms(const std::deque<double>& changes) {
  double squares = 0;
  for (const double change : changes) squares += change * change;
  return std::sqrt(squares / static_cast<double>(changes.size()));
}

}  // namespace

Result<double> FrameTaker::ReadMonitor() {
  auto reading = devices_.monitor->Read();
  // Not a reason to skip this pose: the next would have none either.
  if (!reading && reading.error().code == ErrorCode::kRefused) {
    return Error{ErrorCode::kProtocol, reading.error().message};
  }
  if (!reading) return reading;
  // Also true of NaN.
  if (!(*reading >= kLightIsOut * rig_.light_level) || !std::isfinite(*reading)) {
    return Error{ErrorCode::kProtocol,
                 fmt::format("{}: reads {:.4g} with the light at {:.4g}: the light is out",
                             devices_.monitor->name(), *reading, rig_.light_level)};
  }
  return reading;
}

Result<void> FrameTaker::CheckSteady(Clock& clock) {
  if (!rig_.max_light_change) return {};
  auto before = ReadMonitor();
  std::deque<double> changes;
  for (std::size_t n = 0; n < kSteadyReadings; ++n) {
    if (before.ok()) clock.SleepFor(kBetweenReadings);
    const auto now = before.ok() ? ReadMonitor() : before;
    if (!now) return now.error();
    changes.push_back((*now - *before) / *before);
    before = now;
  }
  const double flicker = Rms(changes);
  if (flicker <= *rig_.max_light_change) return {};
  return Unsteady(fmt::format("flickers by {:.2g} % from reading to reading", 100 * flicker));
}

Result<Exposure> FrameTaker::Take(Seconds exposure, double monitor, std::stop_token stop) {
  double change = 0;
  for (int n = 0; n < kTries; ++n) {
    auto frame = TakeWhole(*devices_.camera, rig_.camera, exposure, stop);
    if (!frame) return frame.error();
    Exposure taken;
    taken.frame = std::move(frame).value();
    taken.monitor = monitor;
    if (!rig_.max_light_change) return taken;
    const auto after = ReadMonitor();
    if (!after) return after.error();
    change = std::abs(*after - monitor) / monitor;
    taken.monitor = (monitor + *after) / 2;
    changes_.push_back(change);
    if (changes_.size() > kSteadyReadings) changes_.pop_front();
    const bool enough = changes_.size() == kSteadyReadings;
    if (const double flicker = Rms(changes_); enough && flicker > *rig_.max_light_change) {
      changes_.clear();
      return Unsteady(fmt::format("changed by {:.2g} % during each of the last {} exposures",
                                  100 * flicker, kSteadyReadings));
    }
    if (change <= *rig_.max_light_change) return taken;
    monitor = *after;
  }
  return Unsteady(fmt::format("changed by more during {} exposures in a row, at last by {:.2g} %",
                              kTries, 100 * change));
}

Error FrameTaker::Unsteady(const std::string& how) const {
  return {ErrorCode::kProtocol,
          fmt::format("{}: the light is not steady within {:.2g} % (light.max_change): it {}",
                      devices_.monitor->name(), 100 * *rig_.max_light_change, how)};
}

Result<Frame> FrameTaker::TakeDark(Seconds exposure, std::stop_token stop) {
  return TakeWhole(*devices_.camera, rig_.camera, exposure, std::move(stop));
}

}  // namespace gonio
