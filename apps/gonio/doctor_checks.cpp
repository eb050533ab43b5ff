// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/doctor_checks.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include "apps/gonio/system_files.h"
#include "drivers/permission.h"
#include "drivers/serial_port.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;
using Kind = Finding::Kind;

// FTDI's adapters keep what they have for so long before they hand it over, 16 ms unless told
// otherwise, which every exchange then takes.
std::optional<Finding> CheckLatency(const std::string& port) {
  const fs::path file =
      fs::path("/sys/bus/usb-serial/devices") / fs::path(port).filename() / "latency_timer";
  const std::string milliseconds = SystemAttribute(file);
  if (milliseconds.empty() || milliseconds == "1") return std::nullopt;
  return Finding{Kind::kHint, port,
                 fmt::format("its adapter holds answers back for {} ms; {}, or: echo 1 > {}",
                             milliseconds, kInstallRules, file.string())};
}

Finding CheckPort(const SerialPortInfo& port) {
  if (!MayOpen(port.path)) return {Kind::kWrong, port.path, kNoPortPermission};
  if (auto slow = CheckLatency(port.path)) return *slow;
  return {Kind::kFine, port.path, port.description.empty() ? "serial port" : port.description};
}

// An interface of the USB test and measurement class.
bool IsInstrument(const fs::path& interface) {
  return SystemAttribute(interface / "bInterfaceClass") == "fe" &&
         SystemAttribute(interface / "bInterfaceSubClass") == "03";
}

std::string DriverOf(const fs::path& interface) {
  std::error_code none;
  const fs::path driver = fs::read_symlink(interface / "driver", none);
  return none ? "" : driver.filename().string();
}

Finding CheckInstrument(const fs::path& device, const fs::path& interface) {
  const std::string subject =
      fmt::format("USB {}:{} {}", SystemAttribute(device / "idVendor"),
                  SystemAttribute(device / "idProduct"), SystemAttribute(device / "serial"));
  if (!MayOpen(fs::path("/") / UsbNode(device))) return {Kind::kWrong, subject, kNoUsbPermission};
  const std::string driver = DriverOf(interface);
  if (driver == "usbtmc") {
    return {Kind::kHint, subject,
            "the system's driver (usbtmc) has it: taken over while gonio runs; programs that have "
            "/dev/usbtmc* open must end"};
  }
  if (!driver.empty() && driver != "usbfs") {
    return {Kind::kWrong, subject, fmt::format("the driver {} has it", driver)};
  }
  return {Kind::kFine, subject, SystemAttribute(device / "product")};
}

}  // namespace

std::vector<Finding> CheckSerialPorts() {
  const Result<std::vector<SerialPortInfo>> ports = ListSerialPorts();
  if (!ports) return {{Kind::kWrong, "serial ports", ports.error().message}};
  if (ports->empty()) return {{Kind::kHint, "serial ports", "none; is the adapter plugged in?"}};
  std::vector<Finding> findings;
  for (const SerialPortInfo& port : *ports) findings.push_back(CheckPort(port));
  return findings;
}

std::vector<Finding> CheckUsbInstruments() {
  std::vector<Finding> findings;
  for (const fs::path& interface : SystemEntries("/sys/bus/usb/devices")) {
    if (!IsInstrument(interface)) continue;
    findings.push_back(CheckInstrument(UsbDeviceOf(interface), interface));
  }
  if (findings.empty()) {
    findings.push_back({Kind::kHint, "USB instruments", "none; is the light or the monitor on?"});
  }
  return findings;
}

std::vector<Finding> CheckPortsOf(const RigConfig& rig) {
  // Each once, with where the rig file first names it.
  std::map<std::string, std::pair<SerialSettings, std::string>> ports;
  const auto add = [&](const std::optional<AxisDevice>& device) {
    if (device) ports.emplace(device->port.port, std::pair(device->port, device->where));
  };
  for (const auto& device : rig.axis_devices) add(device);
  if (rig.filter_wheel) add(rig.filter_wheel->device);
  if (rig.light_device.driver == LightDevice::Driver::kDc4100) {
    const LightDevice& light = rig.light_device;
    ports.emplace(light.port.port, std::pair(light.port, light.where));
  }
  std::vector<Finding> findings;
  for (const auto& [name, line] : ports) {
    const auto port = SerialPort::Open(line.first);
    findings.push_back(port ? Finding{Kind::kFine, name, "can be opened"}
                            : Finding{Kind::kWrong, line.second, port.error().message});
  }
  return findings;
}

}  // namespace gonio
