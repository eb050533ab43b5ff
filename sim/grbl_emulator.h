// SPDX-License-Identifier: Apache-2.0
// A board with Grbl 1.1 and three rotary axes, as its serial line sees it.

#pragma once

#include <array>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "core/clock.h"
#include "sim/sim_motor.h"

namespace gonio {

struct GrblBoard {
  static constexpr int kAxes = 3;
  // Where the axes stand at first, from the machine's zero, which is at the limit switches.
  std::array<double, kAxes> switched_on_at_deg = {-80, -100, -60};
  // Differences from what it was set up with: "$20=0" is {20, 0}.
  std::map<int, double> settings;
  std::string version = "1.1h.20190825:left arm";  // as $I gives it
};

// As much of it as a driver needs, and of what it says when it is told nonsense or the wrong thing;
// written from Grbl's documentation and not from our codec. Moves are made one after the other, all
// axes of each together, in the time of `clock`. Any thread.
//
// Simplified: all axes home at once, a cancelled jog stands at once and is at rest a little later,
// and G-code is always refused.
class GrblEmulator {
 public:
  GrblEmulator(const GrblBoard& board, std::shared_ptr<Clock> clock);
  ~GrblEmulator();

  // Bytes from the line; what is answered so far.
  std::string Receive(std::string_view bytes);
  // What it says by itself: a welcome, an alarm, the end of a homing.
  std::string Unasked();

  double Shaft(int axis = 0) const;  // true angle from the machine's zero, rad
  // Lines it was sent that hold this, since the beginning.
  int Heard(std::string_view part) const;

  // Faults.
  void Reset();                // power fails and comes back, or its port was opened
  void CutMotorPower();        // falls asleep: motors off until it is reset
  void HitLimitSwitch();       // stands; takes nothing but a reset
  void Press(char button);     // '!' hold, 0x18 reset: buttons do what the bytes do
  void LoseSwitches();         // homing finds none from now on
  void HoldBack(int answers);  // to the next so many lines, until it answers the one after

 private:
  using Angles = std::array<double, GrblBoard::kAxes>;  // deg
  enum class State { kIdle, kHold, kJog, kAlarm, kCheck, kHome, kSleep };
  struct Path;

  void Take(char byte);
  void Advance();
  void Say(const std::string& line);
  void Report();
  void RunLines();
  bool TakesLines() const;
  int Obey(const std::string& line);  // 0: ok, else the error
  int Jog(const std::string& words);
  int Set(const std::string& line);
  void PrintSettings();
  void StartHoming();
  void StartPath(const Angles& to, double feed);
  void CancelJog();
  void Halt();  // at once, losing steps if it moved
  void SoftReset();
  void Welcome();
  Angles Position() const;  // true

  const GrblBoard board_;
  const std::shared_ptr<Clock> clock_;
  mutable std::mutex mutex_;
  std::map<int, double> settings_;
  State state_ = State::kAlarm;
  Angles rest_;  // where it stands, from the machine's zero, or the path begins
  std::unique_ptr<Path> path_;
  std::deque<std::pair<Angles, double>> queue_;  // in the counter's coordinates, and feeds
  Angles counter_zero_;                          // true angle where the counter reads 0
  Angles planned_{};                             // where the last path ends, in the counter's
  std::optional<Seconds> braked_at_;
  std::string rx_;
  std::string out_;
  std::string heard_;
  std::string held_back_;
  int held_answers_ = 0;
  bool blocked_ = false;
  bool asked_ = false;
  bool switches_lost_ = false;
  bool at_switch_ = false;
  int reports_ = 0;  // since the last with an offset
};

}  // namespace gonio
