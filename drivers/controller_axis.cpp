// SPDX-License-Identifier: Apache-2.0
#include "drivers/controller_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/units.h"
#include "drivers/move_time.h"

namespace gonio {
namespace {

constexpr Seconds kPoll{0.05};    // while it moves
constexpr Seconds kStopLimit{5};  // braking takes longer only if something is wrong
constexpr Seconds kLeast{1e-3};   // worth waiting for; a clock may be too coarse to pass less
constexpr Seconds kStallLimit{2};
constexpr double kNearMiss = 50;  // tolerances; farther off, the move was ended by somebody

// Notices a motor that stands although its controller says that it moves.
class StallWatch {
 public:
  StallWatch(const Clock& clock, double least) : clock_(clock), least_(least) {}

  bool Stands(double position) {
    if (std::isnan(last_) || std::abs(position - last_) > least_) {
      last_ = position;
      since_ = clock_.Now();
    }
    return clock_.Now() - since_ > kStallLimit;
  }

 private:
  const Clock& clock_;
  const double least_;  // rad: less is noise of the encoder
  double last_ = std::numeric_limits<double>::quiet_NaN();
  Seconds since_{0};
};

}  // namespace

std::string OutsideOf(const AxisLimits& limits, const AxisScale& scale, double least, double most) {
  const auto [low, high] = std::minmax({scale.ToAngle(least), scale.ToAngle(most)});
  if (limits.min_position >= low && limits.max_position <= high) return {};
  return fmt::format(
      "limits of {:.6g} to {:.6g} deg are outside the controller's own, {:.6g} to {:.6g} deg",
      DegFromRad(limits.min_position), DegFromRad(limits.max_position), DegFromRad(low),
      DegFromRad(high));
}

Result<void> ReadBackAs(const std::string& setting, double value, double got, double rounding) {
  if (std::abs(got - value) <= rounding) return {};
  return Error{ErrorCode::kRefused,
               fmt::format("{} was set to {:.6g} and reads {:.6g}", setting, value, got)};
}

Result<std::unique_ptr<Axis>> OpenedAxis(std::unique_ptr<MotionController> controller,
                                         const Result<void>& prepared,
                                         const ControllerAxisSettings& settings, Clock* clock) {
  if (!prepared) {
    return Error{prepared.error().code, settings.name + ": " + prepared.error().message};
  }
  return std::unique_ptr<Axis>(
      std::make_unique<ControllerAxis>(std::move(controller), settings, clock));
}

ControllerAxis::ControllerAxis(std::unique_ptr<MotionController> controller,
                               const ControllerAxisSettings& settings, Clock* clock)
    : controller_(std::move(controller)),
      settings_(settings),
      clock_(clock),
      identity_(controller_->Identity()) {}

// Nobody is left to hear how it went.
ControllerAxis::~ControllerAxis() { (void)Stop(); }

Result<ControllerStatus> ControllerAxis::Status() {
  Result<ControllerStatus> status = controller_->Status();
  if (!status) return Fail(status.error().code, status.error().message);
  if (!status->fault.empty()) {
    doubt_ = status->fault;
  } else if (!status->enabled) {
    doubt_ = "the motor was without power";
  }
  if (!doubt_.empty()) status->homed = false;
  return status;
}

Result<ControllerStatus> ControllerAxis::FreeStatus() {
  Result<ControllerStatus> status = Status();
  if (status.ok() && status->emergency) return Pressed();
  return status;
}

Result<AxisState> ControllerAxis::State() {
  const Result<ControllerStatus> status = FreeStatus();
  if (!status) return status.error();
  return AxisState{.position = settings_.scale.ToAngle(status->position),
                   .homed = status->homed,
                   .moving = status->moving};
}

Result<void> ControllerAxis::Home(std::stop_token stop) {
  const Result<ControllerStatus> before = Status();
  if (!before) return before.error();
  if (!before->enabled) {
    const auto enabled = Named(controller_->Enable());
    // Where it was released meanwhile, as some controllers do not tell, it has worked.
    if (!enabled && before->emergency) return Pressed();
    if (!enabled) return enabled;
  }
  if (const auto started = Named(controller_->StartHoming()); !started) return started;
  doubt_.clear();
  const Result<ControllerStatus> rest = WaitForRest(settings_.home_limit, stop, Doing::kHoming);
  if (!rest) return rest.error();
  if (!rest->homed) return Fail(ErrorCode::kProtocol, "has no reference after homing");
  return {};
}

Result<Seconds> ControllerAxis::StartMove(double position) {
  const AxisLimits& limits = settings_.limits;
  if (!(position >= limits.min_position && position <= limits.max_position)) {
    return Fail(ErrorCode::kRefused,
                fmt::format("{:.6g} deg is outside its limits of {:.6g} to {:.6g} deg",
                            DegFromRad(position), DegFromRad(limits.min_position),
                            DegFromRad(limits.max_position)));
  }
  const Result<ControllerStatus> status = FreeStatus();
  if (!status) return status.error();
  if (!status->homed) {
    return Fail(ErrorCode::kRefused,
                doubt_.empty() ? "is not homed" : fmt::format("is not homed since: {}", doubt_));
  }
  const auto started = Named(controller_->StartMove(settings_.scale.ToUnits(position)));
  if (!started) return started.error();
  target_ = position;
  return TimeOfMove(std::abs(position - settings_.scale.ToAngle(status->position)), limits);
}

Result<void> ControllerAxis::WaitUntilStill(Seconds limit, std::stop_token stop) {
  const Result<ControllerStatus> rest = WaitForRest(limit, stop, Doing::kMove);
  if (!rest) return rest.error();
  if (!rest->homed) return Fail(ErrorCode::kProtocol, "lost its reference on the way");
  const double position = settings_.scale.ToAngle(rest->position);
  const double miss = std::abs(position - target_) / settings_.limits.position_tolerance;
  if (miss <= 1) return {};
  return Fail(miss <= kNearMiss ? ErrorCode::kTimeout : ErrorCode::kProtocol,
              fmt::format("stands at {:.6g} deg instead of {:.6g} deg", DegFromRad(position),
                          DegFromRad(target_)));
}

Result<ControllerStatus> ControllerAxis::WaitForRest(Seconds limit, std::stop_token stop,
                                                     Doing doing) {
  const char* const what = doing == Doing::kHoming ? "homing" : "a move";
  const Seconds begin = clock_->Now();
  StallWatch watch(*clock_, settings_.limits.position_tolerance);
  while (true) {
    const Result<ControllerStatus> status = FreeStatus();
    if (!status) return status;
    if (!status->fault.empty()) {
      (void)Stop();
      return Fail(ErrorCode::kProtocol, fmt::format("{} ended: {}", what, status->fault));
    }
    if (!status->moving) return status;
    const Seconds left = limit - (clock_->Now() - begin);
    if (stop.stop_requested() || left < kLeast) {
      if (const Result<void> stopped = Stop(); !stopped) return stopped.error();
      if (stop.stop_requested()) {
        return Fail(ErrorCode::kCancelled, fmt::format("{} was cancelled", what));
      }
      return Fail(ErrorCode::kTimeout, fmt::format("{} took over {:.3g} s", what, limit.count()));
    }
    // Controllers need not count while they look for their mark.
    if (doing == Doing::kMove && watch.Stands(settings_.scale.ToAngle(status->position))) {
      doubt_ = "it stalled";
      (void)Stop();
      return Fail(
          ErrorCode::kProtocol,
          fmt::format("stalled at {:.6g} deg on its way to {:.6g} deg",
                      DegFromRad(settings_.scale.ToAngle(status->position)), DegFromRad(target_)));
    }
    clock_->SleepFor(std::min(kPoll, left), stop);
  }
}

Result<void> ControllerAxis::Stop() {
  const auto started = Named(controller_->StartStop());
  return started ? WaitForStop() : started;
}

Result<void> ControllerAxis::EmergencyStop() {
  const auto started = Named(controller_->StartEmergencyStop());
  return started ? WaitForStop() : started;
}

// In any thread: so not by Status(), which remembers.
Result<void> ControllerAxis::WaitForStop() {
  const Seconds begin = clock_->Now();
  while (clock_->Now() - begin < kStopLimit) {
    const Result<ControllerStatus> status = controller_->Status();
    if (!status) return Fail(status.error().code, status.error().message);
    if (!status->moving) return {};
    clock_->SleepFor(kPoll);
  }
  return Fail(ErrorCode::kTimeout,
              fmt::format("still moves {:.3g} s after it was told to stop", kStopLimit.count()));
}

Result<void> ControllerAxis::Named(const Result<void>& result) const {
  return result ? result : Fail(result.error().code, result.error().message);
}

Error ControllerAxis::Pressed() const {
  return Fail(ErrorCode::kEmergencyStop, "an emergency stop is pressed");
}

Error ControllerAxis::Fail(ErrorCode code, const std::string& what) const {
  return {code, settings_.name + ": " + what};
}

}  // namespace gonio
