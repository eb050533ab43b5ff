// SPDX-License-Identifier: Apache-2.0
#include "drivers/light_device.h"

#include <fmt/format.h>

#include <algorithm>
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
  settings.leds = device.leds;
  return Dc4100Light::Open(Logged(std::move(port).value(), std::move(log)), settings);
}

constexpr int kMostChannel = 3;

// One LED on its channel, or one for each colour on theirs.
std::vector<Dc4100Led> ReadLeds(const ConfigNode& node,
                                const std::optional<ColourChannels>& colours) {
  if (!colours) {
    const int channel = node.Integer("channel", 0, kMostChannel);
    return {{channel, node.Number("full_current_a", Range::Positive())}};
  }
  if (node.Has("channel")) node.Fail("channel", "light.colours says which channels");
  std::vector<double> currents(colours->size());
  if (node.Has("full_currents_a")) {
    currents = node.Numbers("full_currents_a", colours->size(), Range::Positive());
  } else {
    std::fill(currents.begin(), currents.end(), node.Number("full_current_a", Range::Positive()));
  }
  std::vector<Dc4100Led> leds;
  for (std::size_t i = 0; i < colours->size(); ++i) leds.push_back({(*colours)[i], currents[i]});
  return leds;
}

// Wavelength and power of each colour, where one meter setting does not do for all.
void ReadMonitorColours(const ConfigNode& node, ThorlabsMonitorSettings* settings) {
  for (const LightColour colour : kLightColours) {
    const ConfigNode one = node.Map(ToString(colour));
    settings->colours.push_back(
        {.wavelength_nm = one.Number("wavelength_nm", Range::Between(100, 30000)),
         .reference = one.Number("reference_w", Range::Positive())});
  }
}

}  // namespace

ColourChannels ReadColourChannels(const ConfigNode& node) {
  ColourChannels channels{};
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const char* const name = ToString(kLightColours[i]);
    channels[i] = node.Integer(name, 0, kMostChannel);
    for (std::size_t k = 0; k < i; ++k) {
      if (channels[k] != channels[i]) continue;
      node.Fail(name,
                fmt::format("channel {} is that of {}", channels[i], ToString(kLightColours[k])));
    }
  }
  return channels;
}

LightDevice ReadLightDevice(const ConfigNode& node, const std::optional<ColourChannels>& colours) {
  LightDevice device;
  device.where = node.Where();
  const std::string driver = node.Choice("driver", {"simulated", "dc2200", "dc4100"});
  if (driver == "simulated") return device;
  if (driver == "dc2200") {
    if (colours) node.Fail("driver", "dc2200 has one LED, light.colours needs three");
    device.full_current = node.Number("full_current_a", Range::Positive());
    device.driver = LightDevice::Driver::kDc2200;
    device.usb_serial = node.TextOr("usb_serial", "");
    return device;
  }
  device.driver = LightDevice::Driver::kDc4100;
  device.port.port = node.Text("port");
  device.port.baud = node.IntegerOr("baud", device.port.baud, 1, 4000000);
  device.leds = ReadLeds(node, colours);
  return device;
}

MonitorDevice ReadMonitorDevice(const ConfigNode& node) {
  MonitorDevice device;
  device.where = node.Where();
  if (node.Choice("driver", {"simulated", "thorlabs-power-meter"}) == "simulated") return device;
  device.driver = MonitorDevice::Driver::kThorlabs;
  device.usb_serial = node.TextOr("usb_serial", "");
  ThorlabsMonitorSettings& settings = device.settings;
  settings.averaging = node.IntegerOr("averaging", 1, 1, 10000);
  settings.range = node.NumberOr("range_w", 0, Range::NonNegative());
  if (node.Has("colours")) {
    ReadMonitorColours(node.Map("colours"), &settings);
    return device;
  }
  settings.colours = {{.wavelength_nm = node.Number("wavelength_nm", Range::Between(100, 30000)),
                       .reference = node.Number("reference_w", Range::Positive())}};
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
