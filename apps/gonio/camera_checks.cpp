// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/camera_checks.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "apps/gonio/system_files.h"
#include "drivers/permission.h"
#include "drivers/pixel_unpacking.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;
using Kind = Finding::Kind;

constexpr int kJumbo = 9000;              // bytes of a packet that most cameras can send
constexpr long kBuffers = 4;              // frames that the driver has under way
constexpr long kMebibyte = 1L << 20;      // bytes
constexpr std::uint16_t kControl = 3956;  // GigE Vision's port; any would do

// Of a frame, as it comes.
long FrameBytes(const CameraInfo& camera, const GenicamSettings& settings) {
  const PixelFormat* format = FindPixelFormat(settings.pixel_format);
  return format ? static_cast<long>(format->Bytes(camera.counts())) : 0;
}

// Where the system does not say, nothing is found.
std::vector<Finding> CheckSocket(long frame, const fs::path& root) {
  const std::string text = SystemAttribute(root / "proc/sys/net/core/rmem_max");
  if (text.empty()) return {};
  const long allowed = std::atol(text.c_str());
  const std::string subject = "net.core.rmem_max";
  if (allowed >= frame) {
    return {{Kind::kFine, subject, fmt::format("{} bytes hold a frame of {}", allowed, frame)}};
  }
  const long wanted = (frame + kMebibyte - 1) / kMebibyte * kMebibyte;
  return {{Kind::kHint, subject,
           fmt::format("a socket may hold {0} bytes, a frame has {1}: packets of GigE Vision "
                       "cameras get lost; sudo sysctl -w net.core.rmem_max={2} (for good: echo "
                       "net.core.rmem_max={2} | sudo tee /etc/sysctl.d/60-goniopilot.conf)",
                       allowed, frame, wanted)}};
}

std::vector<Finding> CheckTransfers(long frame, const fs::path& root) {
  const std::string name = "/sys/module/usbcore/parameters/usbfs_memory_mb";
  const std::string text = SystemAttribute(root / name.substr(1));
  if (text.empty()) return {};
  const long allowed = std::atol(text.c_str());
  const long wanted = (kBuffers * frame + kMebibyte - 1) / kMebibyte;
  if (allowed == 0 || allowed >= wanted) {
    return {{Kind::kFine, "usbfs_memory_mb",
             allowed == 0 ? "no limit" : fmt::format("{} MiB hold {} frames", allowed, kBuffers)}};
  }
  return {{Kind::kWrong, "usbfs_memory_mb",
           fmt::format("USB transfers may hold {} MiB, {} frames have {}; echo {} | sudo tee {}",
                       allowed, kBuffers, wanted, wanted, name)}};
}

std::vector<Finding> CheckPackets(const GenicamSettings& settings, const fs::path& root) {
  const std::string interface = InterfaceTowards(settings.address);
  if (interface.empty()) {
    return {{Kind::kWrong, settings.address,
             "no network interface leads there; give one an address beside it: sudo ip address add "
             "ADDRESS/24 dev INTERFACE"}};
  }
  const int mtu = std::atoi(SystemAttribute(root / "sys/class/net" / interface / "mtu").c_str());
  if (mtu == 0) return {};
  const std::string subject = fmt::format("{} ({})", settings.address, interface);
  const int wanted = settings.packet_size > 0 ? settings.packet_size : kJumbo;
  if (mtu >= wanted) return {{Kind::kFine, subject, fmt::format("packets of {} bytes fit", mtu)}};
  const std::string mend = fmt::format("sudo ip link set {} mtu {}", interface, wanted);
  if (settings.packet_size > 0) {
    return {{Kind::kWrong, subject,
             fmt::format("packets may have {} bytes, packet_size_bytes of the rig is {}; {}", mtu,
                         settings.packet_size, mend)}};
  }
  return {{Kind::kHint, subject,
           fmt::format("packets may have {} bytes; larger ones cost less processor time where "
                       "camera and switches can: {}",
                       mtu, mend)}};
}

// The control interface of a USB3 Vision camera.
bool IsCamera(const fs::path& interface) {
  return SystemAttribute(interface / "bInterfaceClass") == "ef" &&
         SystemAttribute(interface / "bInterfaceSubClass") == "05" &&
         SystemAttribute(interface / "bInterfaceProtocol") == "00";
}

}  // namespace

std::vector<Finding> CheckUsbCameras(const fs::path& root) {
  std::vector<Finding> findings;
  for (const fs::path& interface : SystemEntries(root / "sys/bus/usb/devices")) {
    if (!IsCamera(interface)) continue;
    const fs::path device = UsbDeviceOf(interface);
    const auto text = [&](const char* name) { return SystemAttribute(device / name); };
    const std::string subject =
        fmt::format("USB3 Vision {}:{} {}", text("idVendor"), text("idProduct"), text("serial"));
    findings.push_back(MayOpen(root / UsbNode(device))
                           ? Finding{Kind::kFine, subject, text("product")}
                           : Finding{Kind::kWrong, subject, kNoUsbPermission});
  }
  return findings;
}

std::vector<Finding> CheckCameraOf(const RigConfig& rig, const fs::path& root) {
  const CameraDevice& device = rig.camera_device;
  if (device.driver == CameraDevice::Driver::kSimulated) return {};
  const long frame = FrameBytes(rig.camera, device.genicam);
  std::vector<Finding> findings = CheckSocket(frame, root);
  const auto more = device.genicam.address.empty() ? CheckTransfers(frame, root)
                                                   : CheckPackets(device.genicam, root);
  findings.insert(findings.end(), more.begin(), more.end());
  return findings;
}

std::string InterfaceTowards(const std::string& address) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(kControl);
  const int any = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (any < 0) return "";
  // Connecting UDP sends nothing: it asks the system for the way.
  sockaddr_in own{};
  socklen_t size = sizeof own;
  const bool way = inet_pton(AF_INET, address.c_str(), &to.sin_addr) == 1 &&
                   ::connect(any, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 &&
                   ::getsockname(any, reinterpret_cast<sockaddr*>(&own), &size) == 0;
  ::close(any);
  ifaddrs* all = nullptr;
  if (!way || ::getifaddrs(&all) != 0) return "";
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> owner(all, &::freeifaddrs);
  for (const ifaddrs* it = all; it; it = it->ifa_next) {
    if (!it->ifa_addr || it->ifa_addr->sa_family != AF_INET) continue;
    const auto* has = reinterpret_cast<const sockaddr_in*>(it->ifa_addr);
    if (has->sin_addr.s_addr == own.sin_addr.s_addr) return it->ifa_name;
  }
  return "";
}

}  // namespace gonio
