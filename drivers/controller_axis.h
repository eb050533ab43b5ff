// SPDX-License-Identifier: Apache-2.0
// The rules of motion that hold whatever controller is at the other end.

#pragma once

#include <memory>
#include <string>

#include "drivers/axis.h"

namespace gonio {

// What a controller says of itself, in its own unit.
struct ControllerStatus {
  double position = 0;
  bool homed = false;
  bool moving = false;  // homing and braking, too
  bool enabled = true;  // the motor has power
  std::string fault;    // what ended a move, or keeps it from beginning; empty: nothing
  // An emergency stop is pressed, or was since homing; not one that was sent.
  bool emergency = false;
};

// One axis of a controller, so far as ControllerAxis needs it. Calls return when the controller has
// answered, not when the motor stands. Messages of errors need not name the axis.
class MotionController {
 public:
  virtual ~MotionController() = default;
  // Maker, model, serial number, firmware, and the settings made, in one line.
  virtual std::string Identity() const = 0;
  virtual Result<ControllerStatus> Status() = 0;
  virtual Result<void> Enable() = 0;  // gives the motor power
  virtual Result<void> StartHoming() = 0;
  virtual Result<void> StartMove(double position) = 0;
  // Braking; any thread.
  virtual Result<void> StartStop() = 0;
  virtual Result<void> StartEmergencyStop() = 0;
};

// Between the mechanism's angle and a controller's unit.
struct AxisScale {
  double units_per_radian = 1;  // > 0
  double zero = 0;              // rad: the mechanism's angle where the controller reads 0
  bool turned = false;          // the mechanism turns the other way

  double ToUnits(double angle) const {
    return (turned ? -1 : 1) * (angle - zero) * units_per_radian;
  }
  double ToAngle(double units) const { return zero + (turned ? -1 : 1) * units / units_per_radian; }
};

struct ControllerAxisSettings {
  std::string name;   // in every error message
  AxisLimits limits;  // of the mechanism
  AxisScale scale;
  Seconds home_limit{120};
};

// Empty if the limits lie between the controller's own, in its unit; else why not.
std::string OutsideOf(const AxisLimits& limits, const AxisScale& scale, double least, double most);

// kRefused: a setting was set to `value` and reads `got`, which is more than `rounding` off.
Result<void> ReadBackAs(const std::string& setting, double value, double got, double rounding);

// Keeps the promises of Axis on any MotionController:
//
//   - Before each move the controller is asked whether it still has a reference. After a fault, or
//     once the motor was seen without power, only homing proves it.
//   - A move has ended when the controller says so and the position read back is within tolerance.
//     A near miss is kTimeout, which may be repeated; elsewhere somebody has stopped it.
//   - A fault on the way stops the axis, as do a time-out, cancelling, and a position that stays
//     the same for two seconds while the controller says that it moves.
//   - A stop is no fault, and waits until the motor stands.
//   - While an emergency stop is pressed, all but stops are kEmergencyStop; homing finds out
//     whether it still is.
//   - Only homing gives the motor power.
class ControllerAxis final : public Axis {
 public:
  // `clock` outlives the axis.
  ControllerAxis(std::unique_ptr<MotionController> controller,
                 const ControllerAxisSettings& settings, Clock* clock);
  ~ControllerAxis() override;

  const std::string& name() const override { return settings_.name; }
  const AxisLimits& limits() const override { return settings_.limits; }
  const std::string& identity() const override { return identity_; }
  Result<AxisState> State() override;
  Result<void> Home(std::stop_token stop) override;
  Result<Seconds> StartMove(double position) override;
  Result<void> WaitUntilStill(Seconds limit, std::stop_token stop) override;
  Result<void> Stop() override;
  Result<void> EmergencyStop() override;

 private:
  enum class Doing { kHoming, kMove };

  // `homed` only if nothing has happened since that could have cost the reference.
  Result<ControllerStatus> Status();
  // kEmergencyStop where one is pressed.
  Result<ControllerStatus> FreeStatus();
  // Until the motor stands, or a reason why not; then it has been stopped.
  Result<ControllerStatus> WaitForRest(Seconds limit, std::stop_token stop, Doing doing);
  Result<void> WaitForStop();
  Result<void> Named(const Result<void>& result) const;
  Error Pressed() const;
  Error Fail(ErrorCode code, const std::string& what) const;

  const std::unique_ptr<MotionController> controller_;
  const ControllerAxisSettings settings_;
  Clock* const clock_;
  const std::string identity_;
  double target_ = 0;  // rad, of the last move
  std::string doubt_;  // why the reference needs proof; empty: it does not
};

// The axis on a controller that was prepared to be one, or the error of that under the axis' name.
Result<std::unique_ptr<Axis>> OpenedAxis(std::unique_ptr<MotionController> controller,
                                         const Result<void>& prepared,
                                         const ControllerAxisSettings& settings, Clock* clock);

}  // namespace gonio
