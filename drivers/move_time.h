// SPDX-License-Identifier: Apache-2.0
// Ways and times of an axis' moves.

#pragma once

#include <optional>

#include "drivers/axis.h"

namespace gonio {

// Duration of a trapezoidal (or triangular) move over `distance` [rad] >= 0.
Seconds TrapezoidTime(double distance, double max_speed, double acceleration);

// Duration of a move that is made, over `way` [rad] >= 0: trapezoidal, plus what every move of this
// axis costs; zero for no way at all.
Seconds TimeOfMove(double way, const AxisLimits& limits);

// Whether an axis this far [rad] from its target is left where it is: a move of which every one
// costs is not made for less than the tolerance. Samples carry the encoders' readings anyway.
bool Stays(double distance, const AxisLimits& limits);

// Where a move has to turn [rad] so that it ends in the direction of limits.approach, with the play
// of the gear always on the same side; nullopt: it goes straight there, and comes the right way.
std::optional<double> TurningPoint(double from, double target, const AxisLimits& limits);

// Duration of a move over `distance` [rad] of either sign, by way of its turning point; zero for an
// axis that stays.
Seconds MoveTime(double distance, const AxisLimits& limits);

// The limits of targets: inside those of the axis, with room for turning points.
AxisLimits TargetLimits(const AxisLimits& limits);

}  // namespace gonio
