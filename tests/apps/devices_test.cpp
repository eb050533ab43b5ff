// SPDX-License-Identifier: Apache-2.0
// gonio devices, on a machine whose only serial port is one that umockdev pretends to.

#include <nlohmann/json.hpp>

#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using testing::HasSubstr;

constexpr const char* kAdapter = R"(P: /devices/pci0000:00/usb1/1-1
E: DEVTYPE=usb_device
E: SUBSYSTEM=usb
A: busnum=1
A: devnum=5
A: idVendor=0403
A: idProduct=6001
A: manufacturer=FTDI
A: product=Rotation stage
A: serial=A1

P: /devices/pci0000:00/usb1/1-1/1-1:1.0
E: DEVTYPE=usb_interface
E: SUBSYSTEM=usb

P: /devices/pci0000:00/usb1/1-1/1-1:1.0/ttyUSB0
E: SUBSYSTEM=usb-serial

P: /devices/pci0000:00/usb1/1-1/1-1:1.0/ttyUSB0/tty/ttyUSB0
N: ttyUSB0
E: DEVNAME=/dev/ttyUSB0
E: SUBSYSTEM=tty
A: dev=188:0
L: device=../../../ttyUSB0
)";

class Devices : public GonioTest {
 protected:
  // Its standard output.
  std::string WithAdapter(const std::string& description, const std::string& arguments) {
    File("adapter.umockdev", description);
    const Finished finished =
        Shell("umockdev-run --device adapter.umockdev -- \"$GONIO\" devices " + arguments);
    EXPECT_EQ(finished.code, 0) << finished.err;
    return finished.out;
  }
};

TEST_F(Devices, ListsAdaptersByWhatStaysTheSame) {
  const std::string table = WithAdapter(kAdapter, "");
  EXPECT_THAT(table, HasSubstr("/dev/ttyUSB0     0403:6001   usb:A1"));
  EXPECT_THAT(table, HasSubstr("Rotation stage"));
}

TEST_F(Devices, WritesTheSameAsJson) {
  const auto json = nlohmann::json::parse(WithAdapter(kAdapter, "--json -"));
  const auto& ports = json.at("serial_ports");
  ASSERT_EQ(ports.size(), 1u);
  EXPECT_EQ(ports[0].at("path"), "/dev/ttyUSB0");
  EXPECT_EQ(ports[0].at("usb_id"), "0403:6001");
  EXPECT_EQ(ports[0].at("usb_serial"), "A1");
}

// A terminal of the screen is no serial port.
TEST_F(Devices, SaysThatThereIsNone) {
  const std::string screen =
      "P: /devices/virtual/tty/tty1\nE: SUBSYSTEM=tty\nE: DEVNAME=/dev/tty1\n";
  EXPECT_EQ(WithAdapter(screen, ""), "no serial port; is the adapter plugged in?\n");
}

// Example failure is a command that finds no ports because it may not look.
TEST_F(Devices, FailsWhereTheSystemDoesNotTell) {
  File("adapter.umockdev", "P: /devices/nothing\nE: SUBSYSTEM=usb\n");
  const Finished finished = Shell("umockdev-run --device adapter.umockdev -- \"$GONIO\" devices");
  ExpectRefused(finished, 1, {"serial ports cannot be listed: No such file or directory"});
}

}  // namespace
}  // namespace gonio
