// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_motor.h"

#include <algorithm>
#include <cmath>

namespace gonio {
namespace {

// Speeds up for `ramp`, cruises, slows down for `ramp`.
struct Profile {
  double peak;    // rad/s
  double ramp;    // s
  double cruise;  // s

  Profile(double distance, double speed, double acceleration)
      : peak(std::min(speed, std::sqrt(distance * acceleration))),
        ramp(peak / acceleration),
        cruise(peak > 0 ? distance / peak - ramp : 0) {}

  double duration() const { return 2 * ramp + cruise; }

  // Distance covered after `t` seconds.
  double Covered(double t) const {
    const double up = std::clamp(t, 0.0, ramp);
    const double flat = std::clamp(t - ramp, 0.0, cruise);
    const double down = std::clamp(t - ramp - cruise, 0.0, ramp);
    if (ramp <= 0) return 0;
    return peak * (up * up / (2 * ramp) + flat + down - down * down / (2 * ramp));
  }
};

}  // namespace

SimMotor::SimMotor(double position, double max_speed, double acceleration, const Clock& clock,
                   Seconds overhead)
    : max_speed_(max_speed), acceleration_(acceleration), overhead_(overhead), clock_(clock) {
  move_.from = move_.to = position;
}

void SimMotor::Start(double target, double speed_fraction) {
  const std::lock_guard lock(mutex_);
  Move next;
  next.start = clock_.Now();
  next.from = PositionAtLocked(next.start);
  next.to = target;
  next.speed = max_speed_ * speed_fraction;
  const double distance = std::abs(target - next.from);
  next.duration = Seconds(Profile(distance, next.speed, acceleration_).duration());
  if (distance > 0) next.duration += overhead_;
  move_ = next;
}

void SimMotor::Stop() {
  const std::lock_guard lock(mutex_);
  const Seconds now = clock_.Now();
  if (now >= move_.start + move_.duration) return;
  const double position = PositionAtLocked(now);
  move_ = {.from = position, .to = position, .start = now};
}

double SimMotor::PositionAt(Seconds time) const {
  const std::lock_guard lock(mutex_);
  return PositionAtLocked(time);
}

bool SimMotor::MovingBetween(Seconds begin, Seconds end) const {
  const std::lock_guard lock(mutex_);
  return move_.start < end && move_.start + move_.duration > begin;
}

Seconds SimMotor::Remaining() const {
  const std::lock_guard lock(mutex_);
  return std::max(Seconds(0), move_.start + move_.duration - clock_.Now());
}

double SimMotor::PositionAtLocked(Seconds time) const {
  const double distance = std::abs(move_.to - move_.from);
  if (time >= move_.start + move_.duration) return move_.to;
  const double covered =
      Profile(distance, move_.speed, acceleration_).Covered((time - move_.start).count());
  return move_.from + std::copysign(std::min(covered, distance), move_.to - move_.from);
}

}  // namespace gonio
