// SPDX-License-Identifier: Apache-2.0
// What gonio doctor finds about cameras, on machines that are folders.
#include "apps/gonio/camera_checks.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "tests/core/temp_dir.h"
#include "tests/genicam/own_network.h"

namespace gonio {
namespace {

using testing::HasSubstr;
using Kind = Finding::Kind;

class CameraChecks : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    static const bool once = (EnterOwnNetwork(), true);  // its loopback is all there is
    (void)once;
  }
  void Has(const std::string& file, const std::string& text) {
    std::filesystem::create_directories((machine_ / file).parent_path());
    machine_.File(file, text);
  }
  // 2048 x 2048 Mono12: 8 MiB a frame.
  static RigConfig Rig(const std::string& address, int packet_size = 0) {
    RigConfig rig;
    rig.camera = {.width = 2048, .height = 2048, .layout = PixelLayout::kMono};
    rig.camera_device.driver = CameraDevice::Driver::kGenicam;
    rig.camera_device.genicam.address = address;
    if (address.empty()) rig.camera_device.genicam.serial = "123";
    rig.camera_device.genicam.packet_size = packet_size;
    return rig;
  }
  std::vector<Finding> Find(const RigConfig& rig) { return CheckCameraOf(rig, machine_.path()); }
  // A USB3 Vision camera, or what else has this class.
  void PlugIn(const std::string& interface_class) {
    const std::string device = "sys/bus/usb/devices/2-1";
    for (const auto& [name, text] : {std::pair{"busnum", "2\n"},
                                     {"devnum", "7\n"},
                                     {"idVendor", "2676\n"},
                                     {"idProduct", "ba02\n"},
                                     {"product", "acA2040\n"},
                                     {"serial", "21876523\n"}}) {
      Has(device + "/" + name, text);
    }
    Has(device + ":1.0/bInterfaceClass", interface_class + "\n");
    Has(device + ":1.0/bInterfaceSubClass", "05\n");
    Has(device + ":1.0/bInterfaceProtocol", "00\n");
  }

  TempDir machine_;
};

TEST_F(CameraChecks, SaysWhatASocketMustHold) {
  Has("proc/sys/net/core/rmem_max", "212992\n");
  const auto findings = Find(Rig("127.0.0.1"));
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].kind, Kind::kHint);
  EXPECT_THAT(findings[0].what, HasSubstr("a socket may hold 212992 bytes, a frame has 8388608"));
  EXPECT_THAT(findings[0].what, HasSubstr("sudo sysctl -w net.core.rmem_max=8388608 "));
  Has("proc/sys/net/core/rmem_max", "8388608\n");
  EXPECT_EQ(Find(Rig("127.0.0.1"))[0].kind, Kind::kFine);
}

TEST_F(CameraChecks, SaysWhichInterfaceHasSmallPackets) {
  EXPECT_EQ(InterfaceTowards("127.0.0.1"), "lo");
  Has("sys/class/net/lo/mtu", "1500\n");
  const auto findings = Find(Rig("127.0.0.1"));
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].kind, Kind::kHint);
  EXPECT_EQ(findings[0].subject, "127.0.0.1 (lo)");
  EXPECT_THAT(findings[0].what, HasSubstr("sudo ip link set lo mtu 9000"));
  // The rig wants what will not get through.
  const auto wrong = Find(Rig("127.0.0.1", 4000));
  EXPECT_EQ(wrong[0].kind, Kind::kWrong);
  EXPECT_THAT(wrong[0].what, HasSubstr("packet_size_bytes of the rig is 4000; sudo ip link set lo "
                                       "mtu 4000"));
  EXPECT_EQ(Find(Rig("127.0.0.1", 1400))[0].kind, Kind::kFine);
  Has("sys/class/net/lo/mtu", "9000\n");
  EXPECT_EQ(Find(Rig("127.0.0.1"))[0].kind, Kind::kFine);
}

TEST_F(CameraChecks, SaysThatNoInterfaceLeadsToACamera) {
  if (!in_own_network) GTEST_SKIP() << "this machine's network may lead there";
  const auto findings = Find(Rig("192.168.1.20"));
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].kind, Kind::kWrong);
  EXPECT_THAT(findings[0].what, HasSubstr("no network interface leads there"));
}

// Four frames of 8 MiB are under way. A limit of 0 is none.
TEST_F(CameraChecks, SaysWhatUsbTransfersMustHold) {
  const std::string file = "sys/module/usbcore/parameters/usbfs_memory_mb";
  Has(file, "16\n");
  const auto findings = Find(Rig(""));
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].kind, Kind::kWrong);
  EXPECT_THAT(findings[0].what,
              HasSubstr("USB transfers may hold 16 MiB, 4 frames have 32; echo 32 | sudo tee "
                        "/sys/module/usbcore/parameters/usbfs_memory_mb"));
  for (const char* enough : {"32\n", "1000\n", "0\n"}) {
    Has(file, enough);
    EXPECT_EQ(Find(Rig(""))[0].kind, Kind::kFine) << enough;
  }
}

TEST_F(CameraChecks, SaysNothingWhereNothingIsKnown) {
  EXPECT_TRUE(Find(Rig("127.0.0.1")).empty());
  Has("proc/sys/net/core/rmem_max", "212992\n");
  RigConfig simulated = Rig("127.0.0.1");
  simulated.camera_device.driver = CameraDevice::Driver::kSimulated;
  EXPECT_TRUE(Find(simulated).empty());
}

TEST_F(CameraChecks, SaysWhichUsbCameraMayNotBeOpened) {
  PlugIn("ef");
  auto findings = CheckUsbCameras(machine_.path());
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].kind, Kind::kWrong);
  EXPECT_EQ(findings[0].subject, "USB3 Vision 2676:ba02 21876523");
  EXPECT_THAT(findings[0].what, HasSubstr("no permission; copy 60-goniopilot.rules"));
  Has("dev/bus/usb/002/007", "");
  findings = CheckUsbCameras(machine_.path());
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].kind, Kind::kFine);
  EXPECT_EQ(findings[0].what, "acA2040");
}

TEST_F(CameraChecks, PassesOverOtherUsbDevices) {
  PlugIn("08");
  EXPECT_TRUE(CheckUsbCameras(machine_.path()).empty());
}

}  // namespace
}  // namespace gonio
