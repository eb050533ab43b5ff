// SPDX-License-Identifier: Apache-2.0
#include "drivers/controller_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/units.h"

namespace gonio {
namespace {

constexpr Seconds kPoll{0.05};    // while it moves
constexpr Seconds kStopLimit{5};  // braking takes longer only if something is wrong
constexpr Seconds kLeast{1e-3};   // worth waiting for; a clock may be too coarse to pass less

}  // namespace

std::string OutsideOf(const AxisLimits& limits, const AxisScale& scale, double least, double most) {
  const auto [low, high] = std::minmax({scale.ToAngle(least), scale.ToAngle(most)});
  if (limits.min_position >= low && limits.max_position <= high) return {};
  return fmt::format(
      "limits of {:.6g} to {:.6g} deg are outside the controller's own, {:.6g} to {:.6g} deg",
      DegFromRad(limits.min_position), DegFromRad(limits.max_position), DegFromRad(low),
      DegFromRad(high));
}

ControllerAxis::ControllerAxis(std::unique_ptr<MotionController> controller,
                               const ControllerAxisSettings& settings, Clock* clock)
    : controller_(std::move(controller)), settings_(settings), clock_(clock) {}

// Nobody is left to hear how it went.
ControllerAxis::~ControllerAxis() { (void)Stop(); }

Result<ControllerStatus> ControllerAxis::Status() {
  const Result<ControllerStatus> status = controller_->Status();
  return status ? status : Fail(status.error().code, status.error().message);
}

Result<AxisState> ControllerAxis::State() {
  const Result<ControllerStatus> status = Status();
  if (!status) return status.error();
  return AxisState{.position = settings_.scale.ToAngle(status->position),
                   .homed = status->homed,
                   .moving = status->moving};
}

Result<void> ControllerAxis::Home(std::stop_token stop) {
  if (const auto started = Named(controller_->StartHoming()); !started) return started;
  const Result<ControllerStatus> rest = WaitForRest(settings_.home_limit, stop, "homing");
  if (!rest) return rest.error();
  if (!rest->homed) return Fail(ErrorCode::kProtocol, "has no reference after homing");
  return {};
}

Result<void> ControllerAxis::StartMove(double position) {
  const AxisLimits& limits = settings_.limits;
  if (!(position >= limits.min_position && position <= limits.max_position)) {
    return Fail(ErrorCode::kRefused,
                fmt::format("{:.6g} deg is outside its limits of {:.6g} to {:.6g} deg",
                            DegFromRad(position), DegFromRad(limits.min_position),
                            DegFromRad(limits.max_position)));
  }
  const Result<ControllerStatus> status = Status();
  if (!status) return status.error();
  if (!status->homed) return Fail(ErrorCode::kRefused, "is not homed");
  const auto started = Named(controller_->StartMove(settings_.scale.ToUnits(position)));
  if (started) target_ = position;
  return started;
}

Result<void> ControllerAxis::WaitUntilStill(Seconds limit, std::stop_token stop) {
  const Result<ControllerStatus> rest = WaitForRest(limit, stop, "a move");
  if (!rest) return rest.error();
  if (!rest->homed) return Fail(ErrorCode::kProtocol, "lost its reference on the way");
  const double position = settings_.scale.ToAngle(rest->position);
  if (std::abs(position - target_) <= settings_.limits.position_tolerance) return {};
  return Fail(ErrorCode::kProtocol, fmt::format("stands at {:.6g} deg instead of {:.6g} deg",
                                                DegFromRad(position), DegFromRad(target_)));
}

Result<ControllerStatus> ControllerAxis::WaitForRest(Seconds limit, std::stop_token stop,
                                                     const char* doing) {
  const Seconds begin = clock_->Now();
  while (true) {
    const Result<ControllerStatus> status = Status();
    if (!status) return status;
    if (!status->fault.empty()) {
      (void)Stop();
      return Fail(ErrorCode::kProtocol, fmt::format("{} ended: {}", doing, status->fault));
    }
    if (!status->moving) return status;
    const Seconds left = limit - (clock_->Now() - begin);
    if (stop.stop_requested() || left < kLeast) {
      if (const Result<void> stopped = Stop(); !stopped) return stopped.error();
      if (stop.stop_requested()) {
        return Fail(ErrorCode::kCancelled, fmt::format("{} was cancelled", doing));
      }
      return Fail(ErrorCode::kTimeout, fmt::format("{} took over {:.3g} s", doing, limit.count()));
    }
    clock_->SleepFor(std::min(kPoll, left), stop);
  }
}

Result<void> ControllerAxis::Stop() {
  if (const auto started = Named(controller_->StartStop()); !started) return started;
  const Seconds begin = clock_->Now();
  while (clock_->Now() - begin < kStopLimit) {
    const Result<ControllerStatus> status = Status();
    if (!status) return status.error();
    if (!status->moving) return {};
    clock_->SleepFor(kPoll);
  }
  return Fail(ErrorCode::kTimeout,
              fmt::format("still moves {:.3g} s after it was told to stop", kStopLimit.count()));
}

Result<void> ControllerAxis::Named(const Result<void>& result) const {
  return result ? result : Fail(result.error().code, result.error().message);
}

Error ControllerAxis::Fail(ErrorCode code, const std::string& what) const {
  return {code, settings_.name + ": " + what};
}

}  // namespace gonio
