// SPDX-License-Identifier: Apache-2.0
// gonio devices: what is plugged into this machine, as far as we could drive it. Nothing is sent on
// a network unless it is asked for.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "apps/gonio/commands.h"
#include "apps/gonio/json_file.h"
#include "drivers/genicam_list.h"
#include "drivers/serial_port.h"
#include "drivers/usbtmc.h"

namespace gonio {
namespace {

void Print(const std::vector<SerialPortInfo>& ports) {
  if (ports.empty()) {
    fmt::print("no serial port; is the adapter plugged in?\n");
    return;
  }
  // A name that stays the same whatever is plugged in first, where there is one.
  fmt::print("{:16} {:11} {:20} {}\n", "serial port", "USB", "lasting name", "description");
  for (const SerialPortInfo& port : ports) {
    const std::string lasting = port.usb_serial.empty() ? "" : "usb:" + port.usb_serial;
    fmt::print("{:16} {:11} {:20} {}\n", port.path, port.usb_id, lasting, port.description);
  }
}

void Print(const std::vector<UsbDeviceInfo>& instruments) {
  if (instruments.empty()) return;
  fmt::print("{:16} {:20} {}\n", "USB instrument", "serial number", "description");
  for (const UsbDeviceInfo& it : instruments) {
    fmt::print("{:04x}:{:04x}        {:20} {}\n", it.vendor, it.product,
               it.serial.empty() ? "(no permission)" : it.serial, it.description);
  }
}

void Print(const std::vector<GenicamCameraInfo>& cameras) {
  if (cameras.empty()) return;
  fmt::print("{:16} {:20} {:15} {}\n", "camera", "serial number", "address", "description");
  for (const GenicamCameraInfo& it : cameras) {
    fmt::print("{:16} {:20} {:15} {} {}{}\n", it.protocol,
               it.serial.empty() ? "(no permission)" : it.serial, it.address, it.vendor, it.model,
               it.taken ? " (another program controls it)" : "");
  }
}

std::vector<GenicamCameraInfo> FindCameras(const DevicesOptions& options) {
  std::vector<GenicamCameraInfo> cameras = ListUsbCameras();
  for (const std::string& address : options.gige_addresses) {
    const auto camera = AskGigeCamera(address);
    if (!camera) throw std::runtime_error(camera.error().message);
    cameras.push_back(*camera);
  }
  if (options.gige) {
    const std::vector<GenicamCameraInfo> found = SearchGigeCameras();
    cameras.insert(cameras.end(), found.begin(), found.end());
  }
  return cameras;
}

nlohmann::json ToJson(const std::vector<GenicamCameraInfo>& cameras) {
  nlohmann::json list = nlohmann::json::array();
  for (const GenicamCameraInfo& it : cameras) {
    list.push_back({{"protocol", it.protocol},
                    {"vendor", it.vendor},
                    {"model", it.model},
                    {"serial", it.serial},
                    {"name", it.id},
                    {"address", it.address}});
  }
  return list;
}

nlohmann::json ToJson(const std::vector<SerialPortInfo>& ports,
                      const std::vector<UsbDeviceInfo>& instruments,
                      const std::vector<GenicamCameraInfo>& cameras) {
  nlohmann::json list = nlohmann::json::array();
  for (const SerialPortInfo& port : ports) {
    list.push_back({{"path", port.path},
                    {"description", port.description},
                    {"usb_id", port.usb_id},
                    {"usb_serial", port.usb_serial}});
  }
  nlohmann::json usb = nlohmann::json::array();
  for (const UsbDeviceInfo& it : instruments) {
    usb.push_back({{"usb_id", fmt::format("{:04x}:{:04x}", it.vendor, it.product)},
                   {"usb_serial", it.serial},
                   {"description", it.description}});
  }
  return {{"serial_ports", list}, {"usb_instruments", usb}, {"cameras", ToJson(cameras)}};
}

}  // namespace

int DevicesCommand(const DevicesOptions& options) {
  const Result<std::vector<SerialPortInfo>> ports = ListSerialPorts();
  if (!ports) throw std::runtime_error(ports.error().message);
  const Result<std::vector<UsbDeviceInfo>> instruments = ListUsbtmcDevices();
  if (!instruments) throw std::runtime_error(instruments.error().message);
  const std::vector<GenicamCameraInfo> cameras = FindCameras(options);
  if (options.json != "-") {
    Print(*ports);
    Print(*instruments);
    Print(cameras);
  }
  if (!options.json.empty()) WriteJson(options.json, ToJson(*ports, *instruments, cameras));
  return kDone;
}

}  // namespace gonio
