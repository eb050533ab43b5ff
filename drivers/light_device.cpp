// SPDX-License-Identifier: Apache-2.0
#include "drivers/light_device.h"

#include <utility>

#include "core/check.h"
#include "drivers/thorlabs.h"
#include "drivers/usbtmc.h"

namespace gonio {
namespace {

Result<std::unique_ptr<MessageLink>> OpenThorlabs(const std::vector<int>& products,
                                                  const std::string& serial,
                                                  std::shared_ptr<LinkLog> log) {
  auto link =
      UsbtmcDevice::Open({.vendor = kThorlabsVendor, .products = products, .serial = serial});
  if (!link) return link.error();
  return Logged(std::unique_ptr<MessageLink>(std::move(link).value()), std::move(log));
}

Result<std::unique_ptr<Light>> OpenDc2200(const LightDevice& device, const std::string& name,
                                          std::shared_ptr<LinkLog> log) {
  auto link = OpenThorlabs(kDc2200Products, device.usb_serial, std::move(log));
  if (!link) return Error{link.error().code, name + ": " + link.error().message};
  Dc2200Settings settings;
  settings.name = name;
  settings.full_current = device.full_current;
  return Dc2200Light::Open(std::move(link).value(), settings);
}

Result<std::unique_ptr<Light>> OpenDc4100(const LightDevice& device, const std::string& name,
                                          std::shared_ptr<LinkLog> log) {
  auto port = SerialPort::Open(device.port);
  if (!port) return Error{port.error().code, name + ": " + port.error().message};
  Dc4100Settings settings;
  settings.name = name;
  settings.channel = device.channel;
  settings.full_current = device.full_current;
  return Dc4100Light::Open(Logged(std::move(port).value(), std::move(log)), settings);
}

}  // namespace

LightDevice ReadLightDevice(const ConfigNode& node) {
  LightDevice device;
  device.where = node.Where();
  const std::string driver = node.Choice("driver", {"simulated", "dc2200", "dc4100"});
  if (driver == "simulated") return device;
  device.full_current = node.Number("full_current_a", Range::Positive());
  if (driver == "dc2200") {
    device.driver = LightDevice::Driver::kDc2200;
    device.usb_serial = node.TextOr("usb_serial", "");
    return device;
  }
  device.driver = LightDevice::Driver::kDc4100;
  device.port.port = node.Text("port");
  device.port.baud = node.IntegerOr("baud", device.port.baud, 1, 4000000);
  device.channel = node.Integer("channel", 0, 3);
  return device;
}

MonitorDevice ReadMonitorDevice(const ConfigNode& node) {
  MonitorDevice device;
  device.where = node.Where();
  if (node.Choice("driver", {"simulated", "thorlabs-power-meter"}) == "simulated") return device;
  device.driver = MonitorDevice::Driver::kThorlabs;
  device.usb_serial = node.TextOr("usb_serial", "");
  ThorlabsMonitorSettings& settings = device.settings;
  settings.wavelength_nm = node.Number("wavelength_nm", Range::Between(100, 30000));
  settings.averaging = node.IntegerOr("averaging", 1, 1, 10000);
  settings.range = node.NumberOr("range_w", 0, Range::NonNegative());
  settings.reference = node.Number("reference_w", Range::Positive());
  return device;
}

Result<std::unique_ptr<Light>> OpenLight(const LightDevice& device, const std::string& name,
                                         std::shared_ptr<LinkLog> log) {
  switch (device.driver) {
    case LightDevice::Driver::kDc2200:
      return OpenDc2200(device, name, std::move(log));
    case LightDevice::Driver::kDc4100:
      return OpenDc4100(device, name, std::move(log));
    case LightDevice::Driver::kSimulated:
      break;
  }
  GONIO_CHECK(false, "simulated lights are opened elsewhere");
}

Result<std::unique_ptr<Monitor>> OpenMonitor(const MonitorDevice& device, const std::string& name,
                                             std::shared_ptr<LinkLog> log) {
  GONIO_CHECK(device.driver == MonitorDevice::Driver::kThorlabs,
              "simulated monitors are opened elsewhere");
  auto link = OpenThorlabs(kPowerMeterProducts, device.usb_serial, std::move(log));
  if (!link) return Error{link.error().code, name + ": " + link.error().message};
  ThorlabsMonitorSettings settings = device.settings;
  settings.name = name;
  return ThorlabsMonitor::Open(std::move(link).value(), settings);
}

}  // namespace gonio
