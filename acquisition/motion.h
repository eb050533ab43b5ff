// SPDX-License-Identifier: Apache-2.0
// Moving all axes together. The only place where a move is repeated.

#pragma once

#include <span>
#include <stop_token>

#include "acquisition/rig.h"

namespace gonio {

struct Arrival {
  AxisPositions readback{};  // encoders, after settling
  int retries = 0;           // moves repeated because an axis had missed its target
  Seconds still{0};          // session clock when the last axis came to rest, before settling
};

// Asks every encoder. kProtocol: an axis is not homed, so that its position means nothing.
Result<AxisPositions> ReadPositions(Devices& devices);

// Homes one axis after the other, in the order of `motion`. Blocks for minutes.
Result<void> HomeAll(const MotionConfig& motion, Devices& devices, std::stop_token stop);

// Starts all axes, waits until they are still, lets them settle and reads them back. An axis
// outside its tolerance is sent again, rig.motion.retries times.
//
// kRefused: an axis missed its target every time; the message names it. On any error every axis
// has been stopped.
Result<Arrival> MoveAll(const RigConfig& rig, Devices& devices, Clock& clock,
                        const AxisPositions& target, std::stop_token stop);

// The same leg by leg; only at the end they settle. `legs` is not empty.
Result<Arrival> MoveAlong(const RigConfig& rig, Devices& devices, Clock& clock,
                          std::span<const AxisPositions> legs, std::stop_token stop);

// Stops every axis; the first error is returned, but all are stopped. Those that are not open are
// passed over.
Result<void> StopAll(Devices& devices);
// The same, braking as hard as they can: they have to be homed after it.
Result<void> EmergencyStopAll(Devices& devices);

}  // namespace gonio
