// SPDX-License-Identifier: Apache-2.0
// A rotary axis of a Grbl 1.1: an Arduino that steps stepper motors.

#pragma once

#include <memory>

#include "drivers/controller_axis.h"
#include "drivers/grbl_machine.h"

namespace gonio::grbl {

// Opens an axis (drivers/controller_axis.h has its rules) by its letter, "X", "Y", "Z" or "A".
// $100 and so on are steps per degree in place of settings.scale.units_per_radian; the machine's
// coordinates, below the switch that homing finds, have the travel of $130. Speed goes with each
// move, the acceleration is kept in $120 and read back.
//
// kRefused, with what to change: no such axis, limits outside its travel, a speed above $110, a
// tolerance finer than its steps, and settings with which its position could not be relied on.
// Those are homing ($22) or soft limits ($20) off, motors without power between moves ($1),
// positions in inches ($13). Moves nothing.
//
// All of the machine is homed, stopped and lost together: drivers/grbl_machine.h. "$X", which
// would pretend that it had a position, is never sent.
Result<std::unique_ptr<Axis>> OpenAxis(std::shared_ptr<Machine> machine, char letter,
                                       const ControllerAxisSettings& settings, Clock* clock);

}  // namespace gonio::grbl
