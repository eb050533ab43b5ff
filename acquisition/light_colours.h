// SPDX-License-Identifier: Apache-2.0
// A light with colours in front of a mono camera: one colour after the other.

#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "acquisition/rig.h"
#include "drivers/move_time.h"

namespace gonio {

// The channel that frames in this colour stand for.
inline int ChannelOf(LightColour colour) { return static_cast<int>(colour); }

// The colour of that name. Throws ConfigError "there is no colour NAME".
LightColour ColourNamed(const std::string& name);

// In which colours the frames of a pose are lit, in turn: to and fro, so that a pose begins with
// the `last` colour of the one before and a wheel never turns back. A light without colours has one
// turn, as it is.
std::vector<std::optional<LightColour>> ColoursInTurn(
    const RigConfig& rig, const std::optional<LightColour>& last = std::nullopt);

// What a pose spends on changes of colour: two of them, the wheel's turns and settling. Zero for a
// light without colours.
inline Seconds ColourChangesOf(const RigConfig& rig) {
  if (!rig.by_colour) return Seconds(0);
  Seconds sum = 2 * rig.colour_settle;
  if (!rig.filter_wheel) return sum;
  const auto& [red, green, blue] = rig.filter_wheel->positions;
  return sum + MoveTime(green - red, rig.filter_wheel->limits) +
         MoveTime(blue - green, rig.filter_wheel->limits);
}

// Changes the colour of the light, and tells the monitor. One thread.
class ColourChanger {
 public:
  // Keeps references; all must outlive it.
  ColourChanger(const RigConfig& rig, Devices& devices, Clock& clock)
      : rig_(rig), devices_(devices), clock_(clock) {}

  // Once it returns, frames may be exposed in this colour. What is selected already is read back
  // and costs nothing more. kProtocol, too, where the light refuses: the next pose would have none
  // either.
  Result<void> Select(LightColour colour, std::stop_token stop);
  // What was selected may no longer be: the next time it is selected as if for the first.
  void Forget() { selected_.reset(); }

 private:
  const RigConfig& rig_;
  Devices& devices_;
  Clock& clock_;
  std::optional<LightColour> selected_;
};

}  // namespace gonio
