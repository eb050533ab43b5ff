// SPDX-License-Identifier: Apache-2.0
// Which light and which monitor a rig has, and how they are reached.

#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/config.h"
#include "drivers/dc2200_light.h"
#include "drivers/dc4100_light.h"
#include "drivers/link_log.h"
#include "drivers/serial_port.h"
#include "drivers/thorlabs_monitor.h"

namespace gonio {

// The channels of red, green and blue on a driver of several LEDs.
using ColourChannels = std::array<int, 3>;

struct LightDevice {
  enum class Driver { kSimulated, kDc2200, kDc4100 };
  std::string where;  // in the rig file: "rig.yaml:60: light.device"
  Driver driver = Driver::kSimulated;
  std::string usb_serial;       // kDc2200; empty: the only one that is plugged in
  double full_current = 0;      // kDc2200; A at level 1
  SerialSettings port;          // kDc4100
  std::vector<Dc4100Led> leds;  // kDc4100: one, or red, green and blue
};

struct MonitorDevice {
  enum class Driver { kSimulated, kThorlabs };
  std::string where;
  Driver driver = Driver::kSimulated;
  std::string usb_serial;            // empty: the only one that is plugged in
  ThorlabsMonitorSettings settings;  // but for the name
};

// Read the `device` mappings of `light` and `monitor` in a rig file; docs/rig-files.md lists their
// keys. Throw ConfigError.
// `colours`: the rig's `light.colours`, if it has them; a driver of one LED refuses them.
LightDevice ReadLightDevice(const ConfigNode& node, const std::optional<ColourChannels>& colours);
MonitorDevice ReadMonitorDevice(const ConfigNode& node);
// The mapping `light.colours`: red, green and blue, each a channel of its own.
ColourChannels ReadColourChannels(const ConfigNode& node);

// Open a device that is not simulated, switched off, and its settings made. Errors name it by
// `name`. kRefused: not there, not permitted, not what the file says, or it cannot do it.
Result<std::unique_ptr<Light>> OpenLight(const LightDevice& device, const std::string& name,
                                         std::shared_ptr<LinkLog> log);
Result<std::unique_ptr<Monitor>> OpenMonitor(const MonitorDevice& device, const std::string& name,
                                             std::shared_ptr<LinkLog> log);

}  // namespace gonio
