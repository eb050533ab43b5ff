// SPDX-License-Identifier: Apache-2.0
// One rotary axis of the goniometer.

#pragma once

#include <stop_token>
#include <string>

#include "core/clock.h"
#include "core/error.h"

namespace gonio {

// Where an axis may go and how fast. Angles are those of the mechanism, after the driver has
// applied its sign, offset and steps per radian; the rig's geometry (acquisition/kinematics.h)
// comes on top.
struct AxisLimits {
  double min_position = 0;        // rad
  double max_position = 0;        // rad, > min_position
  double max_speed = 0;           // rad/s, > 0
  double acceleration = 0;        // rad/s^2, > 0
  double position_tolerance = 0;  // rad, > 0: a move that ends within this has arrived
  // Where it is not 0 [rad], every move ends over the last part of its way in this direction, so
  // that the play of the gear is always on the same side; for the caller (drivers/move_time.h).
  double approach = 0;
  // Taken by every move on top, however short: fly-back, a clutch, the settling of a heavy stage.
  Seconds move_overhead{0};
};

// What the controller reported about itself at one instant.
struct AxisState {
  double position = 0;  // rad, read from the encoder, never the set-point
  bool homed = false;
  bool moving = false;
};

// A motorised rotary axis with an absolute position once homed.
//
// An axis is opened by its implementation's factory and starts out not homed:
//
//             Home()                 StartMove()
//   not homed ------> still at q  ---------------->  moving
//       ^                 ^                            |
//       | power loss      |  WaitUntilStill(), Stop()  |
//       +-----------------+----------------------------+
//
// Every implementation keeps these promises; tests/conformance/axis.h checks them:
//
//   1. After StartMove(q) and a successful WaitUntilStill(), |State()->position - q| is at most
//      limits().position_tolerance.
//   2. StartMove() to a target outside limits(), to NaN, or before Home() is kRefused, and nothing
//      is sent to the motor.
//   3. Stop() and EmergencyStop() may be called from any thread, at any time, any number of times.
//      The axis is at rest when they return.
//   4. After kDisconnected every later call returns kDisconnected. No call reconnects behind the
//      caller's back.
//   5. The destructor stops the motor.
//   6. After a fault, or once its motor has been without power, an axis is not homed, whatever the
//      controller says, until Home() succeeds.
//
// Except for the stops, calls on one axis come from one thread. Different axes are independent:
// start several moves, then wait for each.
//
// Errors: kTimeout       the controller did not answer, or the move did not end, in time
//         kDisconnected  the link is gone; open the device again
//         kProtocol      the answer made no sense; stop and look at the log
//         kRefused       the request breaks a promise above; fix the caller
//         kCancelled     `stop` was requested; the axis has been stopped
//         kEmergencyStop somebody has pressed one, as far as the controller tells
class Axis {
 public:
  virtual ~Axis() = default;

  // Name given in the rig's configuration, e.g. "light_azimuth". Appears in every error message.
  virtual const std::string& name() const = 0;

  virtual const AxisLimits& limits() const = 0;

  // What the device said it is when it was opened, and the settings it was given: one line for the
  // session's record.
  virtual const std::string& identity() const = 0;

  // Asks the controller. Takes one round trip, typically 5 to 20 ms.
  virtual Result<AxisState> State() = 0;

  // Finds the reference mark and makes positions absolute. Blocks; the axis may sweep its whole
  // range, so the other arm must be clear.
  virtual Result<void> Home(std::stop_token stop) = 0;

  // Starts a move to `position` (rad) and returns at once: how long it should take, by distance,
  // speed and acceleration.
  virtual Result<Seconds> StartMove(double position) = 0;

  // Blocks until the last move has ended at its target, or fails with kTimeout after `limit`,
  // having stopped the axis. kTimeout, too, for one that ended beside its target and may be
  // repeated. Mechanical ringing is the caller's to wait out.
  virtual Result<void> WaitUntilStill(Seconds limit, std::stop_token stop) = 0;

  // Brakes as it does at the end of a move.
  virtual Result<void> Stop() = 0;

  // Brakes as hard as the controller can, which may cost it its reference.
  virtual Result<void> EmergencyStop() = 0;
};

}  // namespace gonio
