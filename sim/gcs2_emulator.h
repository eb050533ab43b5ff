// SPDX-License-Identifier: Apache-2.0
// A controller of PI's with a rotary stage on one of its axes, as its serial line sees it.

#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"
#include "sim/sim_motor.h"

namespace gonio {

struct Gcs2Stage {
  int address = 0;                        // on a daisy chain; 0: there is none
  std::vector<std::string> axes = {"1"};  // as SAI? lists them
  std::string axis = "1";                 // that with the stage; the others always move
  std::string unit = "DEG";               // empty: it does not know the parameter
  bool knows_halt = true;                 // HLT
  bool knows_enable = false;              // EAX
  double least_deg = -170;                // TMN?
  double most_deg = 175;                  // TMX?
  double fastest_deg_s = 40;              // VEL may be so much at most
  double saved_speed_deg_s = 10;          // VEL after power-up
  double switched_on_at_deg = -50;        // from the reference switch, where it stands at first
};

// As much of it as a driver needs; written from what is known of the command set and not from our
// codec. Like the real one it answers nothing to commands, keeps the last error until it is asked
// for, calls a stop an error, and refuses to move without a reference or with its servo off. A move
// takes the time of `clock`, with an acceleration of its own whatever is set, and settles after
// it; until then it is not on target. Any thread.
class Gcs2Emulator {
 public:
  Gcs2Emulator(const Gcs2Stage& stage, std::shared_ptr<Clock> clock);

  // Bytes from the line; what is answered to the questions they complete.
  std::string Receive(std::string_view bytes);

  double Shaft() const;  // true angle from the reference switch, rad

  // Faults.
  void Reset();          // power fails and comes back: servo off, no reference
  void CutMotorPower();  // stands, servo off until switched on
  void Fail(int error);  // stands, servo off, with this error
  void SkipNextError();  // the next reply to ERR? is empty

 private:
  struct Command;
  std::string AnswerByte(char command);
  std::string Answer(const Command& command);
  std::string AnswerOfAxis(const Command& command);
  void Obey(const Command& command);
  void Move(double degrees);
  void Refer();
  void Settle();
  void Halt();
  bool OnTarget() const;
  double Counter() const;  // deg
  std::string Sent(const std::string& reply) const;

  const Gcs2Stage stage_;
  const std::shared_ptr<Clock> clock_;
  mutable std::mutex mutex_;
  SimMotor motor_;  // its zero is the reference switch
  std::string pending_;
  int error_ = 0;
  bool skip_error_ = false;
  bool servo_ = false;
  bool enabled_ = false;
  bool referenced_ = false;
  bool referring_ = false;
  Seconds settled_at_{0};
  double settles_from_ = 0;  // deg, beside the target
  double counter_zero_;      // rad, where the controller counts from
  double speed_;             // deg/s
  double acceleration_ = 80;
  double deceleration_ = 80;
};

}  // namespace gonio
