// SPDX-License-Identifier: Apache-2.0
// A Zaber rotary stage as its serial line sees it.

#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "core/clock.h"
#include "sim/sim_motor.h"

namespace gonio {

struct ZaberStage {
  int device = 1;
  long steps_per_turn = 384000;    // limit.cycle.dist
  long least = -384000;            // microsteps: limit.min
  long most = 384000;              // limit.max
  double fastest = 384000;         // microsteps / s: what maxspeed may be at most
  double switched_on_at = -60000;  // microsteps from the reference mark, where it stands at first
};

// Device with one axis, firmware 7, of which as much as a driver needs; written from the published
// message format and not from our codec, so that a mistake in that cannot hide. Moves take the time
// of `clock`, with an acceleration of its own whatever is set. Like the real one it moves without a
// reference if it is told to, from wherever it thinks it is. Any thread.
class ZaberEmulator {
 public:
  ZaberEmulator(const ZaberStage& stage, std::shared_ptr<Clock> clock);
  ~ZaberEmulator();

  // Bytes from the line; what is answered to the commands they complete.
  std::string Receive(std::string_view bytes);

  // True angle from the reference mark, rad.
  double Shaft() const;

  // Faults.
  void Reset();          // power fails and comes back: stands, and has no reference
  void Stall();          // stands, flag FS until the next move
  void CutMotorPower();  // stands, its driver disabled (FO) until enabled
  // The button at its input: stands, flag FH, and is not enabled until it is released.
  void PressEmergencyStop();
  void ReleaseEmergencyStop();

 private:
  struct Axis;
  std::string Answer(std::string line);
  std::string Do(std::string_view data, bool* accepted);
  std::string Get(std::string_view setting, bool* accepted) const;
  std::string Set(std::string_view rest, bool* accepted);
  std::string Move(std::string_view rest, bool* accepted);

  const ZaberStage stage_;
  const std::shared_ptr<Clock> clock_;
  mutable std::mutex mutex_;
  std::string pending_;
  std::unique_ptr<Axis> axis_;
};

}  // namespace gonio
