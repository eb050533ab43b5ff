// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "drivers/move_time.h"

namespace gonio {
namespace {

constexpr double kHomingSpeed = 0.25;  // of full speed

}  // namespace

SimAxis::SimAxis(std::string name, const AxisLimits& limits, const SimAxisOptions& options,
                 std::shared_ptr<SimMotor> motor, Clock& clock, Random random)
    : name_(std::move(name)),
      limits_(limits),
      options_(options),
      motor_(std::move(motor)),
      clock_(clock),
      random_(random),
      // Not homed: the encoder counts from wherever it was switched on.
      zero_(motor_->Position()) {}

SimAxis::~SimAxis() { motor_->Stop(); }

Error SimAxis::Fail(ErrorCode code, const std::string& what) const {
  return {code, fmt::format("{}: {}", name_, what)};
}

Result<void> SimAxis::CheckLink() const {
  const std::lock_guard lock(mutex_);
  if (!connected_) return Fail(ErrorCode::kDisconnected, "the link is gone");
  return {};
}

double SimAxis::Encoder() const {
  double position = motor_->Position();
  {
    const std::lock_guard lock(mutex_);
    position -= zero_;
  }
  const double step = options_.encoder_resolution;
  return step > 0 ? std::round(position / step) * step : position;
}

Result<AxisState> SimAxis::State() {
  if (auto link = CheckLink(); !link) return link.error();
  AxisState state;
  state.position = Encoder();
  state.moving = motor_->Moving();
  const std::lock_guard lock(mutex_);
  state.homed = homed_;
  return state;
}

Result<void> SimAxis::SleepThroughMove(Seconds limit, const char* operation, std::stop_token stop) {
  const Seconds remaining = motor_->Remaining();
  clock_.SleepFor(std::min(remaining, limit), stop);
  if (auto link = CheckLink(); !link) return link;
  if (stop.stop_requested()) {
    motor_->Stop();
    return Fail(ErrorCode::kCancelled, fmt::format("{}: cancelled", operation));
  }
  if (remaining > limit) {
    motor_->Stop();
    return Fail(ErrorCode::kTimeout,
                fmt::format("{}: not done after {:.3g} s", operation, limit.count()));
  }
  return {};
}

Result<void> SimAxis::Home(std::stop_token stop) {
  if (auto link = CheckLink(); !link) return link;
  {
    const std::lock_guard lock(mutex_);
    homed_ = false;
  }
  motor_->Start(options_.reference, kHomingSpeed);
  if (auto done = SleepThroughMove(options_.home_limit, "homing", stop); !done) return done;
  if (motor_->Position() != options_.reference) {
    return Fail(ErrorCode::kCancelled, "homing: stopped before the reference mark");
  }
  const std::lock_guard lock(mutex_);
  homed_ = true;
  zero_ = 0;
  target_ = options_.reference;
  return {};
}

Result<Seconds> SimAxis::StartMove(double position) {
  if (auto link = CheckLink(); !link) return link.error();
  {
    const std::lock_guard lock(mutex_);
    if (!homed_) return Fail(ErrorCode::kRefused, "move: not homed");
    // Also true of NaN.
    if (!(position >= limits_.min_position && position <= limits_.max_position)) {
      return Fail(ErrorCode::kRefused,
                  fmt::format("move to {:.4f} deg: outside {:.4f} .. {:.4f}", DegFromRad(position),
                              DegFromRad(limits_.min_position), DegFromRad(limits_.max_position)));
    }
    target_ = position;
  }
  // A controller that reads its target on the encoder leaves the motor alone.
  const double same = options_.encoder_resolution / 2;
  const double way = std::abs(Encoder() - position);
  if (!motor_->Moving() && way <= same) return Seconds(0);
  motor_->Start(position + options_.repeatability * random_.Normal());
  return TimeOfMove(way, limits_);
}

Result<void> SimAxis::WaitUntilStill(Seconds limit, std::stop_token stop) {
  if (auto link = CheckLink(); !link) return link;
  if (auto slept = SleepThroughMove(limit, "move", stop); !slept) return slept;
  double target = 0;
  {
    const std::lock_guard lock(mutex_);
    if (!homed_) return Fail(ErrorCode::kRefused, "move: not homed");
    target = target_;
  }
  const double miss = std::abs(Encoder() - target);
  if (miss > limits_.position_tolerance) {
    return Fail(ErrorCode::kTimeout, fmt::format("move to {:.4f} deg: came to rest {:.4f} deg off",
                                                 DegFromRad(target), DegFromRad(miss)));
  }
  return {};
}

Result<void> SimAxis::Stop() {
  if (auto link = CheckLink(); !link) return link;
  motor_->Stop();
  return {};
}

void SimAxis::PullPlug() {
  motor_->Stop();
  const std::lock_guard lock(mutex_);
  connected_ = false;
}

void SimAxis::LosePower() {
  motor_->Stop();
  const double position = motor_->Position();
  const std::lock_guard lock(mutex_);
  homed_ = false;
  zero_ = position;
}

}  // namespace gonio
