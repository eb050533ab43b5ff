// SPDX-License-Identifier: Apache-2.0
// What can be wrong with a machine before the first byte is sent, as the system tells.

#pragma once

#include <string>
#include <vector>

#include "acquisition/rig.h"

namespace gonio {

struct Finding {
  enum class Kind {
    kFine,
    kHint,   // works, but not as well as it could
    kWrong,  // will not work
  };
  Kind kind = Kind::kFine;
  std::string subject;  // "/dev/ttyUSB0"
  std::string what;     // and what to do about it
};

// Whether serial ports may be opened, and how long their adapters hold bytes back.
std::vector<Finding> CheckSerialPorts();

// Whether USB instruments (USBTMC) may be opened, and who else has hold of them.
std::vector<Finding> CheckUsbInstruments();

// Opens, and closes, each port that a rig names. Boards that reset when their port is opened do.
std::vector<Finding> CheckPortsOf(const RigConfig& rig);

}  // namespace gonio
