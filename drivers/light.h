// SPDX-License-Identifier: Apache-2.0
// The light source and the monitor that watches it.

#pragma once

#include <optional>
#include <stop_token>
#include <string>

#include "core/error.h"

namespace gonio {

// What a light with colours can be lit in, one at a time: LEDs, or filters in front of it. In the
// order of the channels everywhere.
enum class LightColour { kRed, kGreen, kBlue };
inline constexpr LightColour kLightColours[] = {LightColour::kRed, LightColour::kGreen,
                                                LightColour::kBlue};
// "red", "green", "blue": as in rig files and in the log.
const char* ToString(LightColour colour);

// A dimmable light. Promises, checked by tests/conformance/light.h:
//
//   1. SetLevel() outside 0 .. 1, or NaN, is kRefused and changes nothing.
//   2. Level() reads the device; it is not a memory of what was asked for.
//   3. The destructor switches the light off.
//
// A light with colours gives one of them at a time and keeps two promises more:
//
//   4. Once Select() has returned, it gives that colour, alone and at the level that was set
//      before; SetLevel() leaves the colour as it is.
//   5. Selected() reads the device. More than one colour at a time is an error.
//
// Before the first Select() it is not said which colour SetLevel() lights.
class Light {
 public:
  virtual ~Light() = default;
  virtual const std::string& name() const = 0;
  // What the device said it is when it was opened, and the settings it was given, on one line.
  virtual const std::string& identity() const = 0;
  // Fraction of full power, 0 = off.
  virtual Result<void> SetLevel(double level) = 0;
  virtual Result<double> Level() = 0;

  // All three, or none: then the light is as it is, and what follows is of no use.
  virtual bool has_colours() const { return false; }
  // Blocks until the colour is there: seconds, where a filter wheel has to turn. kRefused: the
  // light has no colours, or the wheel missed its place; kCancelled: by `stop`.
  virtual Result<void> Select(LightColour colour, std::stop_token stop);
  // What it gives now; empty: nothing, since it is off or stands between two filters.
  virtual Result<std::optional<LightColour>> Selected();
};

// A power meter that sees a constant fraction of the light. Promises, checked by
// tests/conformance/monitor.h:
//
//   1. Read() is proportional to the light, and 1 where that is as at calibration.
//   2. A reading begins after the call; it is never one that was left over.
//   3. What the meter cannot measure, like more than its range, is an error and never a number.
class Monitor {
 public:
  virtual ~Monitor() = default;
  virtual const std::string& name() const = 0;
  // What the device said it is when it was opened, and the settings it was given, on one line.
  virtual const std::string& identity() const = 0;
  // Optical power relative to the reading at calibration (1 = as then); noise included.
  virtual Result<double> Read() = 0;
  // Readings from now on are of light of this colour, relative to those of the same colour at
  // calibration. A monitor that makes no difference between colours does nothing.
  virtual Result<void> Expect(LightColour) { return {}; }
};

}  // namespace gonio
