// SPDX-License-Identifier: Apache-2.0
// gonio devices: what is plugged into this machine.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "apps/gonio/commands.h"
#include "apps/gonio/json_file.h"
#include "drivers/serial_port.h"

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

nlohmann::json ToJson(const std::vector<SerialPortInfo>& ports) {
  nlohmann::json list = nlohmann::json::array();
  for (const SerialPortInfo& port : ports) {
    list.push_back({{"path", port.path},
                    {"description", port.description},
                    {"usb_id", port.usb_id},
                    {"usb_serial", port.usb_serial}});
  }
  return {{"serial_ports", list}};
}

}  // namespace

int DevicesCommand(const DevicesOptions& options) {
  const Result<std::vector<SerialPortInfo>> ports = ListSerialPorts();
  if (!ports) throw std::runtime_error(ports.error().message);
  if (options.json != "-") Print(*ports);
  if (!options.json.empty()) WriteJson(options.json, ToJson(*ports));
  return kDone;
}

}  // namespace gonio
