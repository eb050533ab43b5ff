// SPDX-License-Identifier: Apache-2.0
// A Newport SMC100CC with a rotary stage, as its serial line sees it.

#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "core/clock.h"
#include "sim/sim_motor.h"

namespace gonio {

struct Smc100Stage {
  int address = 1;
  double least_deg = -170;          // SL
  double most_deg = 175;            // SR
  double fastest_deg_s = 40;        // VA may be so much at most
  double switched_on_at_deg = -50;  // from the reference mark, where it stands at first
};

// As much of it as a driver needs; written from the published command set and not from our codec.
// Like the real one it answers nothing to commands and passes over those it does not obey, having
// noted the error. Moves take the time of `clock`, with an acceleration of its own whatever is set.
// Any thread.
class Smc100Emulator {
 public:
  Smc100Emulator(const Smc100Stage& stage, std::shared_ptr<Clock> clock);

  // Bytes from the line; what is answered to the queries they complete.
  std::string Receive(std::string_view bytes);

  double Shaft() const { return motor_.Position(); }  // true angle from the reference mark, rad

  // Faults.
  void Reset();                    // power fails and comes back
  void CutMotorPower();            // stands, DISABLE until told MM1
  void Fail(unsigned error_bits);  // stands; the positioner reports these errors until homed

 private:
  std::string Answer(std::string line);
  std::string Obey(const std::string& command, const std::string& argument);
  void Move(double degrees);
  int State();

  const Smc100Stage stage_;
  const std::shared_ptr<Clock> clock_;
  mutable std::mutex mutex_;
  SimMotor motor_;  // its zero is the reference mark
  std::string pending_;
  bool referenced_ = false;
  bool homing_ = false;
  bool moved_ = false;  // since it was homed
  bool disabled_ = false;
  double counter_zero_;  // rad, where the controller counts from
  double velocity_;      // deg/s
  double acceleration_;  // deg/s^2
  char error_ = '@';
  unsigned errors_ = 0;
};

}  // namespace gonio
