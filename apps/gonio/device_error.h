// SPDX-License-Identifier: Apache-2.0
// A real device that failed.

#pragma once

#include <stdexcept>
#include <string>

#include "drivers/link_log.h"

namespace gonio {

// Before there was a session to record it. main() shows it, and what last went over the wires.
class DeviceError : public std::runtime_error {
 public:
  DeviceError(const std::string& what, const LinkLog& wires);
  const std::string& wires() const { return wires_; }  // lines

 private:
  std::string wires_;
};

// The last lines of the wires, for standard error: below a message that says what went wrong.
std::string LastOnTheWires(const LinkLog& wires);

}  // namespace gonio
