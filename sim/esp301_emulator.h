// SPDX-License-Identifier: Apache-2.0
// A Newport ESP301 with a rotary stage on one of its axes, as its serial line sees it.

#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "core/clock.h"
#include "sim/sim_motor.h"

namespace gonio {

struct Esp301Stage {
  int axis = 1;
  int unit = 7;                     // SN: degrees
  double least_deg = -170;          // SL
  double most_deg = 175;            // SR
  double fastest_deg_s = 40;        // VA may be so much at most
  double saved_speed_deg_s = 10;    // VA after power-up
  double switched_on_at_deg = -50;  // from the home mark, where it stands at first
};

// As much of it as a driver needs; written from what is known of the command set and not from our
// codec. Like the real one it answers nothing to commands, passes over those it does not obey
// having queued the error, keeps ten errors at most, and moves without a reference if it is told
// to, from wherever it thinks it is. Moves take the time of `clock`, with an acceleration of its
// own whatever is set. Any thread.
class Esp301Emulator {
 public:
  Esp301Emulator(const Esp301Stage& stage, std::shared_ptr<Clock> clock);

  // Bytes from the line; what is answered to the questions they complete.
  std::string Receive(std::string_view bytes);

  double Shaft() const { return motor_.Position(); }  // true angle from the home mark, rad

  // Faults.
  void Reset();               // power fails and comes back: motor off, counts from where it stands
  void CutMotorPower();       // stands, the motor off until told MO
  void Fail(int number);      // stands; the axis' error of this number is queued
  void QueueError(int code);  // as it would be read, of any axis
  void Blurt(std::string_view line);  // sent, unasked, before the next answer

 private:
  std::string Answer(std::string_view command);
  std::string AnswerOfAxis(const std::string& name, const std::string& argument);
  void Obey(const std::string& name, const std::string& argument);
  void Set(double* setting, double value, double most, int error);
  void Move(double degrees);
  void SearchHome();
  void Settle();
  void Halt();
  bool Moving() const;
  double Counter() const;  // deg
  void Queue(int code);
  int TakeError();

  const Esp301Stage stage_;
  const std::shared_ptr<Clock> clock_;
  mutable std::mutex mutex_;
  SimMotor motor_;  // its zero is the home mark
  std::string pending_;
  std::string unasked_;
  std::deque<int> errors_;
  bool powered_ = false;
  bool searching_ = false;
  Seconds search_ends_{0};
  double counter_zero_;  // rad, where the controller counts from
  double speed_;         // deg/s
  double acceleration_ = 80;
  double deceleration_ = 80;
};

}  // namespace gonio
