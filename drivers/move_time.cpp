// SPDX-License-Identifier: Apache-2.0
#include "drivers/move_time.h"

#include <cmath>

namespace gonio {

Seconds TrapezoidTime(double distance, double max_speed, double acceleration) {
  if (distance <= 0) return Seconds(0);
  if (distance < max_speed * max_speed / acceleration) {
    return Seconds(2 * std::sqrt(distance / acceleration));
  }
  return Seconds(distance / max_speed + max_speed / acceleration);
}

Seconds TimeOfMove(double way, const AxisLimits& limits) {
  if (way <= 0) return Seconds(0);
  return TrapezoidTime(way, limits.max_speed, limits.acceleration) + limits.move_overhead;
}

bool Stays(double distance, const AxisLimits& limits) {
  return limits.move_overhead > Seconds(0) && std::abs(distance) <= limits.position_tolerance;
}

std::optional<double> TurningPoint(double from, double target, const AxisLimits& limits) {
  const double approach = limits.approach;
  const double way = std::copysign(1, approach) * (target - from);
  if (approach == 0 || way >= std::abs(approach)) return std::nullopt;
  return target - approach;
}

Seconds MoveTime(double distance, const AxisLimits& limits) {
  if (Stays(distance, limits)) return Seconds(0);
  const auto turn = TurningPoint(0, distance, limits);
  if (!turn) return TimeOfMove(std::abs(distance), limits);
  return TimeOfMove(std::abs(*turn), limits) + TimeOfMove(std::abs(limits.approach), limits);
}

AxisLimits TargetLimits(const AxisLimits& limits) {
  AxisLimits targets = limits;
  (limits.approach > 0 ? targets.min_position : targets.max_position) += limits.approach;
  return targets;
}

}  // namespace gonio
