// SPDX-License-Identifier: Apache-2.0
// A machine into which devices are plugged that are not there, by umockdev.

#pragma once

#include <memory>
#include <string>

#include "sim/usb_double.h"

namespace gonio {

// A USB adapter with a serial port.
struct SerialAdapter {
  UsbPlate plate{.vendor = 0x0403,
                 .product = 0x6001,
                 .maker = "FTDI",
                 .description = "USB serial adapter",
                 .serial = {}};
  std::string node = "ttyUSB0";  // appears as /dev/ttyUSB0
  std::string line;              // what its wire leads to: "/dev/pts/3" (sim/pty_server.h)
};

// Libraries that look for devices find those of the bench, and no others, in programs that
//
//   - were started with LD_PRELOAD=libumockdev-preload.so.0, and
//   - have UMOCKDEV_DIR in their environment, where the bench has put it.
//
// This one and the programs it starts, that is: the first of the two it needs only to be seen from
// here. One bench at a time, which outlives whatever is open in this program, for nobody would
// answer that any more. One thread; the devices' calls come from another.
class UsbBench {
 public:
  UsbBench();
  ~UsbBench();
  UsbBench(const UsbBench&) = delete;
  UsbBench& operator=(const UsbBench&) = delete;

  static constexpr const char* kPreload = "libumockdev-preload.so.0";
  static bool SeenFromHere();

  // As with a real cable; a device can be plugged in again. It outlives the bench.
  void Plug(UsbDouble* device);
  void Unplug(UsbDouble* device);
  // Throws ConfigError if there is already one of this name.
  void Plug(const SerialAdapter& adapter);
  void Unplug(const SerialAdapter& adapter);

  // Whether the system's own driver has hold of the instrument's interface, as it has at first.
  bool HeldBySystem(const UsbDouble* device) const;
  // The file that stands for the device's node, whose permissions are the device's.
  std::string NodeFile(const UsbDouble* device) const;

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace gonio
