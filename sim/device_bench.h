// SPDX-License-Identifier: Apache-2.0
// A whole rig of doubles, plugged into a machine that is not there.

#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "core/clock.h"
#include "drivers/axis.h"
#include "drivers/axis_device.h"
#include "drivers/light_device.h"
#include "sim/usb_bench.h"
#include "sim/wire_bench.h"

namespace gonio {

// What a rig file says of its real devices.
struct BenchDevices {
  std::vector<AxisDevice> axes;
  std::vector<AxisLimits> limits;  // of each
  LightDevice light;
  MonitorDevice monitor;
};

// Serial ports appear under the names that the file gives them, by USB serial number or as
// /dev/NAME; instruments with the serial numbers it asks for. The power meter sees the LEDs, each
// with the reference power of its colour (`monitor.settings`) at full current.
//
// Only programs started with UsbBench::kPreload while it lives see it; one bench at a time.
class DeviceBench {
 public:
  // Doubles move in the time of `clock`. Throws ConfigError if a port is neither under /dev nor
  // given by serial number.
  DeviceBench(const BenchDevices& devices, std::shared_ptr<Clock> clock);
  ~DeviceBench();

  // Of the axes, in order: where the mechanism is [rad].
  double Angle(std::size_t axis) const { return wires_.Angle(axis); }
  // The light, relative to level 1. Any thread.
  double LampPower() const;
  // Of a light of several LEDs: the one that is on; empty: none, or more than one. Any thread.
  std::optional<LightColour> LampColour() const;

 private:
  struct Instruments;

  void PlugPorts();
  void PlugInstruments(const BenchDevices& devices);

  WireBench wires_;
  std::unique_ptr<Instruments> instruments_;
  UsbBench usb_;
  int ports_ = 0;
};

}  // namespace gonio
