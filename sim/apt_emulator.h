// SPDX-License-Identifier: Apache-2.0
// A Thorlabs controller with a rotary stage, as its USB line sees it.

#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "core/clock.h"
#include "sim/sim_motor.h"

namespace gonio {

struct AptStage {
  std::uint8_t module = 0x50;  // 0x21 .. 0x2a: a card, in a rack that says who it is
  std::uint8_t channel = 1;
  bool servo = true;  // statuses are DCSTATUSUPDATEs, which have to be acknowledged
  std::int32_t serial = 27000042;
  std::string model = "KDC101";
  double counts_per_deg = 1919.64;   // a PRM1-Z8's
  double velocity_units = 42941.66;  // for 1 deg/s
  double acceleration_units = 14.66;
  double fastest_deg_s = 40;              // more is clipped
  std::int32_t homing_velocity = 429417;  // units
  std::int32_t backlash = 1919;           // counts, whenever it is switched on
  double switched_on_at_deg = -50;        // from the reference mark, where it stands at first
  double switch_at_deg = 1e6;  // where a limit switch ends its way; out of reach: there is none
  bool keeps_homed = false;    // shows as homed while it is homed again
  Seconds sluggish{0};         // until its status shows that it was told to move
};

// A K10CR1, whose stepper motor is counted in other units.
AptStage K10cr1();
// Any rotary stage by its name: "PRM1-Z8", "K10CR1", "DDR100", "DDR05", "HDR50", "NR360", with a
// controller that drives it. Throws ConfigError if it is another.
AptStage AptStageOf(const std::string& name);

// As much of it as a driver needs; written from the published messages and not from our codec. Like
// the real one it answers nothing to commands, moves without a reference if it is told to, and says
// unasked when a move has ended. What it does not know is answered by HW_RESPONSE. Moves take the
// time of `clock`, with an acceleration of its own whatever is set. Any thread.
class AptEmulator {
 public:
  AptEmulator(const AptStage& stage, std::shared_ptr<Clock> clock);

  // Bytes from the line; what has been said since, and what is answered to the messages they
  // complete.
  std::string Receive(std::string_view bytes);

  double Shaft() const { return motor_.Position(); }  // true angle from the reference mark, rad
  std::int32_t backlash() const;
  std::int32_t max_velocity() const;

  // Faults.
  void Reset();                      // power fails and comes back: settings, too, are as ever
  void CutMotorPower();              // stands, its channel disabled
  void Fail(std::uint32_t bits);     // stands; the status shows these bits until it is homed
  void SetBits(std::uint32_t bits);  // more bits of the status, nothing else
  // HW_RICHRESPONSE goes out before what it would say next: unasked, or instead of obeying `about`.
  void Complain(std::uint16_t about, std::uint16_t code, const std::string& notes);
  void Complain();  // HW_RESPONSE, which names nothing, the same way: unasked
  void Chatter();   // as if another program had asked for updates: one before each answer

 private:
  struct Header;
  std::string Obey(const Header& header, std::string_view data);
  std::string Get(const Header& header);
  bool Set(const Header& header, std::string_view data);
  bool Move(const Header& header, std::string_view data);
  void PowerOn();
  void Start(double deg, double deg_s);
  void Halt();
  std::string Unasked();  // of what has ended by now
  std::string Status(std::uint16_t id);
  std::uint32_t Bits() const;
  std::int32_t Counter() const;
  std::string Long(std::uint16_t id, const std::string& data, int source = 0) const;
  std::string HwResponse() const;

  const AptStage stage_;
  const std::shared_ptr<Clock> clock_;
  mutable std::mutex mutex_;
  SimMotor motor_;  // its zero is the reference mark
  std::string pending_;
  std::string complaint_;
  std::uint16_t complained_of_ = 0;
  bool chatter_ = false;
  bool homed_ = false;
  bool was_homed_ = false;  // when its homing began
  bool homing_ = false;
  bool moving_ = false;  // and MOVE_COMPLETED is still to be sent
  bool backwards_ = false;
  bool enabled_ = true;
  bool at_switch_ = false;
  Seconds started_{0};
  double counter_zero_ = 0;  // rad, where the controller counts from
  std::int32_t velocity_ = 0;
  std::int32_t acceleration_ = 0;
  std::int32_t backlash_ = 0;
  std::uint32_t faults_ = 0;
  std::uint32_t more_bits_ = 0;
  int unacknowledged_ = 0;  // statuses
};

}  // namespace gonio
