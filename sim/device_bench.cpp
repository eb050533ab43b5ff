// SPDX-License-Identifier: Apache-2.0
#include "sim/device_bench.h"

#include <fmt/format.h>

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
      : of_light(devices.light), power_at_full(devices.monitor.settings.reference) {}

  // W that fall on the monitor's sensor.
  double Power() const {
    const bool serial = of_light.driver == LightDevice::Driver::kDc4100;
    const double current = serial ? dc4100.Current(of_light.channel) : dc2200.Current();
    return power_at_full * current / of_light.full_current;
  }

  const LightDevice of_light;
  const double power_at_full;
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
  return instruments_->Power() / instruments_->power_at_full;
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
