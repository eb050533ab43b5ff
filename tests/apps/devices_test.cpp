// SPDX-License-Identifier: Apache-2.0
// gonio devices, on a machine whose only serial port is one that umockdev pretends to.

#include <nlohmann/json.hpp>

#include "sim/gige_camera.h"
#include "tests/apps/gonio_process.h"
#include "tests/genicam/own_network.h"

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

// A GigE Vision camera on this machine's loopback.
class GigeDevices : public Devices {
 protected:
  static void SetUpTestSuite() {
    static const bool once = (EnterOwnNetwork(), true);
    (void)once;
  }
  void Serve() {
    auto served = GigeCamera::Serve({}, [](const GigeExposure&, std::vector<std::uint16_t>&) {});
    ASSERT_TRUE(served.ok()) << served.error().message;
    camera_ = std::move(served).value();
  }
  nlohmann::json Cameras(const std::string& arguments) {
    return nlohmann::json::parse(WithAdapter(kAdapter, "--json - " + arguments)).at("cameras");
  }

 private:
  std::unique_ptr<GigeCamera> camera_;
};

// Example failure is a search that nobody asked for: it goes out on every network of a lab.
TEST_F(GigeDevices, AreAskedOnlyWhenTheyAreNamed) {
  Serve();
  EXPECT_EQ(Cameras("").size(), 0u);
  const auto cameras = Cameras("--gige-address 127.0.0.1");
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras[0].at("protocol"), "GigEVision");
  EXPECT_EQ(cameras[0].at("vendor"), "Goniopilot");
  EXPECT_EQ(cameras[0].at("model"), "GigE double");
  EXPECT_EQ(cameras[0].at("serial"), "GP0001");
  EXPECT_EQ(cameras[0].at("address"), "127.0.0.1");
  EXPECT_THAT(WithAdapter(kAdapter, "--gige-address 127.0.0.1"),
              HasSubstr("GigEVision       GP0001               127.0.0.1       Goniopilot GigE "
                        "double\n"));
}

TEST_F(GigeDevices, AreSearchedForOnDemand) {
  if (!in_own_network) GTEST_SKIP() << "a search would go out on the network";
  Serve();
  const auto cameras = Cameras("--gige");
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras[0].at("serial"), "GP0001");
  EXPECT_EQ(cameras[0].at("address"), "127.0.0.1");
}

TEST_F(GigeDevices, SayWhereNoneAnswers) {
  File("adapter.umockdev", kAdapter);
  for (const auto& [address, words] : {std::pair{"127.0.0.1", "no camera at 127.0.0.1"},
                                       std::pair{"camera.lab", "camera.lab is no IPv4 address"}}) {
    ExpectRefused(Shell(std::string("umockdev-run --device adapter.umockdev -- \"$GONIO\" devices "
                                    "--gige-address ") +
                        address),
                  1, {words});
  }
}

}  // namespace
}  // namespace gonio
