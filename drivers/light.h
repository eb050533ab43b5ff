// SPDX-License-Identifier: Apache-2.0
// The light source and the monitor that watches it.

#pragma once

#include <string>

#include "core/error.h"

namespace gonio {

// A dimmable light. Promises, checked by tests/conformance/light.h:
//
//   1. SetLevel() outside 0 .. 1, or NaN, is kRefused and changes nothing.
//   2. Level() reads the device; it is not a memory of what was asked for.
//   3. The destructor switches the light off.
class Light {
 public:
  virtual ~Light() = default;
  virtual const std::string& name() const = 0;
  // What the device said it is when it was opened, and the settings it was given, on one line.
  virtual const std::string& identity() const = 0;
  // Fraction of full power, 0 = off.
  virtual Result<void> SetLevel(double level) = 0;
  virtual Result<double> Level() = 0;
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
};

}  // namespace gonio
