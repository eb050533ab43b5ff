// SPDX-License-Identifier: Apache-2.0
// A rotary stage of Zaber's, on a chain that speaks ASCII.

#pragma once

#include <memory>

#include "drivers/controller_axis.h"
#include "drivers/zaber_chain.h"

namespace gonio::zaber {

// Where an axis is on its chain.
struct Address {
  int device = 1;  // 1 .. 99
  int axis = 1;    // 1 .. 9
};

// Opens an axis (drivers/controller_axis.h has its rules). Steps per turn come from the controller
// (limit.cycle.dist) in place of settings.scale.units_per_radian, so a stage cannot be driven at
// another one's scale. Speed and acceleration are set to the limits and read back.
//
// It has lost its reference, so is not homed, while it warns of that (WR, WH): after power-up, a
// reset, or being moved by force.
//
// kRefused: no such axis, not a rotary one, limits outside the controller's, a speed it cannot
// have. Moves nothing. `chain` may be shared with other axes; `clock` outlives the axis.
Result<std::unique_ptr<Axis>> OpenAxis(std::shared_ptr<Chain> chain, const Address& address,
                                       const ControllerAxisSettings& settings, Clock* clock);

}  // namespace gonio::zaber
