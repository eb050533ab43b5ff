// SPDX-License-Identifier: Apache-2.0
#include "sim/device_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "sim/dc4100_emulator.h"
#include "sim/pty_server.h"
#include "sim/scpi_instruments.h"
#include "sim/usbtmc_emulator.h"

namespace gonio {
namespace {

constexpr std::string_view kByUsbSerial = "usb:";
constexpr std::string_view kDevices = "/dev/";

bool Begins(std::string_view text, std::string_view beginning) {
  return text.substr(0, beginning.size()) == beginning;
}

UsbPlate PlateOf(int product, const char* description, const std::string& serial) {
  return {.vendor = 0x1313,
          .product = product,
          .maker = "Thorlabs",
          .description = description,
          .serial = serial.empty() ? "SIMULATED" : serial};
}

SerialAdapter AdapterFor(const std::string& port, int number, const std::string& line) {
  SerialAdapter adapter;
  adapter.line = line;
  adapter.node = fmt::format("ttyUSB{}", 100 + number);
  if (Begins(port, kByUsbSerial)) {
    adapter.plate.serial = port.substr(kByUsbSerial.size());
  } else if (Begins(port, kDevices)) {
    adapter.node = port.substr(kDevices.size());
    adapter.plate.serial = fmt::format("SIMULATED{}", number);
  } else {
    throw ConfigError(port + ": neither usb:SERIAL nor under /dev/");
  }
  return adapter;
}

}  // namespace

struct DeviceBench::Instruments {
  explicit Instruments(const BenchDevices& devices)
      : of_light(devices.light), monitored(devices.monitor.settings.colours) {}

  // W of that LED at full current.
  double AtFull(std::size_t led) const {
    return monitored.empty() ? 1 : monitored[std::min(led, monitored.size() - 1)].reference;
  }
  std::size_t Leds() const { return of_light.leds.empty() ? 1 : of_light.leds.size(); }
  // Its current over full current.
  double Relative(std::size_t led) const {
    if (of_light.leds.empty()) return dc2200.Current() / of_light.full_current;
    return dc4100.Current(of_light.leds[led].channel) / of_light.leds[led].full_current;
  }
  // W that fall on the monitor's sensor.
  double Power() const {
    double sum = 0;
    for (std::size_t i = 0; i < Leds(); ++i) sum += AtFull(i) * Relative(i);
    return sum;
  }

  const LightDevice of_light;
  const std::vector<MonitoredLight> monitored;
  Dc2200Emulator dc2200;
  Dc4100Emulator dc4100;
  PtyServer serial_light{[this](std::string_view bytes) { return dc4100.Receive(bytes); }};
  PowerMeterEmulator meter{[this] { return Power(); }};
  std::unique_ptr<UsbtmcEmulator> light;
  std::unique_ptr<UsbtmcEmulator> monitor;
};

DeviceBench::DeviceBench(const BenchDevices& devices, std::shared_ptr<Clock> clock)
    : wires_(std::move(clock)), instruments_(std::make_unique<Instruments>(devices)) {
  for (std::size_t i = 0; i < devices.axes.size(); ++i) {
    wires_.Add(devices.axes[i], devices.limits[i]);
  }
  wires_.Serve();
  PlugPorts();
  PlugInstruments(devices);
}

DeviceBench::~DeviceBench() = default;

double DeviceBench::LampPower() const {
  double sum = 0;
  for (std::size_t i = 0; i < instruments_->Leds(); ++i) sum += instruments_->Relative(i);
  return sum;
}

std::optional<LightColour> DeviceBench::LampColour() const {
  std::optional<LightColour> on;
  for (std::size_t i = 0; i < instruments_->Leds() && i < std::size(kLightColours); ++i) {
    if (instruments_->Relative(i) <= 0) continue;
    if (on) return std::nullopt;
    on = kLightColours[i];
  }
  return on;
}

void DeviceBench::PlugInstruments(const BenchDevices& devices) {
  Instruments& it = *instruments_;
  if (devices.light.driver == LightDevice::Driver::kDc2200) {
    it.light = std::make_unique<UsbtmcEmulator>(
        PlateOf(0x80c8, "DC2200", devices.light.usb_serial),
        [&it](std::string_view message) { return it.dc2200.Receive(message); });
    usb_.Plug(it.light.get());
  }
  if (devices.light.driver == LightDevice::Driver::kDc4100) {
    usb_.Plug(AdapterFor(devices.light.port.port, ports_, it.serial_light.path()));
  }
  if (devices.monitor.driver == MonitorDevice::Driver::kThorlabs) {
    it.monitor = std::make_unique<UsbtmcEmulator>(
        PlateOf(0x8078, "PM100D", devices.monitor.usb_serial),
        [&it](std::string_view message) { return it.meter.Receive(message); });
    usb_.Plug(it.monitor.get());
  }
}

void DeviceBench::PlugPorts() {
  for (const auto& [port, server] : wires_.lines()) {
    usb_.Plug(AdapterFor(port, ports_++, server->path()));
  }
}

}  // namespace gonio
