// SPDX-License-Identifier: Apache-2.0
// gonio doctor, on machines that umockdev pretends to.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using testing::HasSubstr;

std::string Adapter(int latency_ms = 16) {
  return fmt::format(R"(P: /devices/pci0000:00/usb1/1-1/1-1:1.0/ttyUSB0
E: SUBSYSTEM=usb-serial
A: latency_timer={}\n

P: /devices/pci0000:00/usb1/1-1/1-1:1.0/ttyUSB0/tty/ttyUSB0
N: ttyUSB0
E: DEVNAME=/dev/ttyUSB0
E: SUBSYSTEM=tty
A: dev=188:0
L: device=../../../ttyUSB0
)",
                     latency_ms);
}

// A power meter whose second interface is the one for measuring.
constexpr const char* kMeter = R"(P: /devices/pci0000:00/usb1/1-2
N: bus/usb/001/006
E: DEVTYPE=usb_device
E: DEVNAME=/dev/bus/usb/001/006
E: SUBSYSTEM=usb
A: busnum=1\n
A: devnum=6\n
A: idVendor=1313\n
A: idProduct=8078\n
A: product=PM100D\n
A: serial=P0012345\n

P: /devices/pci0000:00/usb1/1-2/1-2:1.1
E: DEVTYPE=usb_interface
E: SUBSYSTEM=usb
A: bInterfaceClass=fe\n
A: bInterfaceSubClass=03\n
L: driver=../../../../../bus/usb/drivers/usbtmc
)";

class Doctor : public GonioTest {
 protected:
  Finished On(const std::string& machine, const std::string& arguments = "") {
    File("machine.umockdev", machine);
    return Shell("umockdev-run --device machine.umockdev -- \"$GONIO\" doctor " + arguments);
  }
};

TEST_F(Doctor, NamesAnAdapterThatHoldsAnswersBack) {
  const Finished finished = On(Adapter());
  EXPECT_EQ(finished.code, 0) << finished.err;
  EXPECT_THAT(finished.out, HasSubstr("hint   /dev/ttyUSB0: its adapter holds answers back for 16 "
                                      "ms; copy 60-goniopilot.rules"));
  EXPECT_THAT(finished.out, HasSubstr("hint   USB instruments: none"));
  EXPECT_THAT(On(Adapter(1)).out, HasSubstr("fine   /dev/ttyUSB0: serial port"));
}

TEST_F(Doctor, NamesTheDriverThatHasAnInstrument) {
  const std::string both = fmt::format("{}\n{}", Adapter(), kMeter);
  const auto json = nlohmann::json::parse(On(both, "--json -").out);
  ASSERT_EQ(json.at("findings").size(), 2u);
  const auto& meter = json.at("findings")[1];
  EXPECT_EQ(meter.at("kind"), "hint");
  EXPECT_EQ(meter.at("subject"), "USB 1313:8078 P0012345");
  EXPECT_THAT(meter.at("what").get<std::string>(),
              HasSubstr("the system's driver (usbtmc) has it"));
}

TEST_F(Doctor, TriesThePortsOfARig) {
  File("rig.yaml", "version: 1\n");
  ExpectRefused(On(Adapter(), "--rig rig.yaml"), 2, {"rig.yaml:1: name: is missing"});
  const Finished finished = On(Adapter(), "--rig bench-wire.yaml");
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.out, HasSubstr("wrong  "));
  EXPECT_THAT(finished.out,
              HasSubstr("axes.light_azimuth.device: usb:BENCH-CHAIN: no serial port with this USB "
                        "serial number"));
}

}  // namespace
}  // namespace gonio
