// SPDX-License-Identifier: Apache-2.0
// A rotary stage behind one of PI's controllers that speak GCS 2.

#pragma once

#include <memory>
#include <string>

#include "drivers/controller_axis.h"
#include "drivers/gcs2_line.h"

namespace gonio::gcs2 {

struct AxisAddress {
  int controller = 0;      // on a daisy chain, from 1; 0: there is none
  std::string axis = "1";  // as SAI? lists it
};

// Opens an axis (drivers/controller_axis.h has its rules). It must count in degrees, if the
// controller tells (SPA? 0x07000601), and its limits (TMN?, TMX?) must include the settings'.
// Velocity, acceleration and deceleration (VEL, ACC, DEC) are set and read back, now and before
// each homing, since a reset forgets them. It is homed if it says so (FRF?), but not after a homing
// that did not end well. Homing (FRF) uses the reference switch.
//
// A move has ended once the axis is on target (ONT?), too. An emergency stop (0x18) stops all axes
// of the controller; a motion error is none of one axis either: all that it has are homed again.
//
// kRefused: another device, no such axis, another unit, limits outside the controller's, a speed it
// cannot have. Moves nothing. `line` may be shared with other axes; `clock` outlives the axis.
Result<std::unique_ptr<Axis>> OpenAxis(std::shared_ptr<Line> line, const AxisAddress& address,
                                       const ControllerAxisSettings& settings, Clock* clock);

}  // namespace gonio::gcs2
