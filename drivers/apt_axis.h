// SPDX-License-Identifier: Apache-2.0
// A rotary stage of Thorlabs', behind a controller that speaks APT.

#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "drivers/apt_link.h"
#include "drivers/controller_axis.h"
#include "drivers/serial_port.h"

namespace gonio::apt {

// Opens the port of a controller, "usb:27000001" as a rule, 115200 baud with RTS/CTS, and throws
// away what it still says to whoever had it open before. Takes 0.1 s of `clock`.
//
// A controller's USB adapter has numbers of its own (0403:faf0), which Linux has to be told of
// once.
Result<std::unique_ptr<SerialPort>> OpenPort(const SerialSettings& settings, Clock* clock);

// Opens an axis (drivers/controller_axis.h has its rules). `stage` is one of those in
// drivers/apt_stages.h, whose scale comes in place of settings.scale.units_per_radian, since the
// controller does not tell it; a controller that does not drive such a stage is refused. Speed and
// acceleration are set to the limits, and the controller's own way of taking up backlash is
// switched off, at opening and before each homing, as a controller forgets them with its power.
//
// Of limits these controllers know switches only: what the arm can reach is the rig's to know. A
// move that ends at a switch is a fault. The axis is homed while status bit 0x400 says so, and from
// the beginning of a homing not before its end.
//
// kRefused: an unknown stage, another controller, a speed it cannot have. Moves nothing. `link` may
// be shared with other axes; `clock` outlives the axis.
Result<std::unique_ptr<Axis>> OpenAxis(std::shared_ptr<Link> link, const Address& address,
                                       std::string_view stage,
                                       const ControllerAxisSettings& settings, Clock* clock);

}  // namespace gonio::apt
