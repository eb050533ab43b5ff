// SPDX-License-Identifier: Apache-2.0
// Which controller an axis has, and how it is reached.

#pragma once

#include <string>

#include "core/config.h"
#include "drivers/serial_port.h"

namespace gonio {

enum class AxisProtocol { kZaber, kSmc100, kApt, kEsp301, kGcs2, kGrbl };

struct AxisDevice {
  std::string where;  // in the rig file: "rig.yaml:14: axes.light_azimuth.device"
  AxisProtocol protocol = AxisProtocol::kZaber;
  SerialSettings port;
  int address = 1;      // of the controller on its line
  int axis = 1;         // of the controller
  std::string stage;    // where the controller does not tell (drivers/apt_stages.h)
  double zero = 0;      // rad: the mechanism's angle where the controller reads 0
  bool turned = false;  // the mechanism turns the other way
};

// Reads the `device` mapping of an axis in a rig file; docs/rig-files.md lists its keys. The line's
// speed and flow control are those of the protocol unless it says otherwise. Throws ConfigError.
AxisDevice ReadAxisDevice(const ConfigNode& node);

}  // namespace gonio
