// SPDX-License-Identifier: Apache-2.0
#include "drivers/axis_opener.h"

#include <fmt/format.h>

#include <utility>

#include "drivers/apt_axis.h"
#include "drivers/esp301_axis.h"
#include "drivers/gcs2_axis.h"
#include "drivers/gcs2_line.h"
#include "drivers/grbl_axis.h"
#include "drivers/smc100_axis.h"
#include "drivers/zaber_axis.h"
#include "drivers/zaber_chain.h"

namespace gonio {
namespace {

struct OpenOn {
  const AxisDevice& device;
  const ControllerAxisSettings& settings;
  Clock* clock;

  Result<std::unique_ptr<Axis>> operator()(const std::shared_ptr<zaber::Chain>& chain) const {
    return zaber::OpenAxis(chain, {.device = device.address, .axis = device.axis}, settings, clock);
  }
  Result<std::unique_ptr<Axis>> operator()(const std::shared_ptr<smc100::Line>& line) const {
    return smc100::OpenAxis(line, device.address, settings, clock);
  }
  Result<std::unique_ptr<Axis>> operator()(const std::shared_ptr<apt::Link>& link) const {
    const apt::Address motor{
        .module = device.address == 0 ? apt::kUsbUnit : apt::kFirstBay + device.address - 1,
        .channel = device.axis};
    return apt::OpenAxis(link, motor, device.stage, settings, clock);
  }
  Result<std::unique_ptr<Axis>> operator()(const std::shared_ptr<esp301::Line>& line) const {
    return esp301::OpenAxis(line, {.axis = device.axis}, settings, clock);
  }
  Result<std::unique_ptr<Axis>> operator()(const std::shared_ptr<gcs2::Line>& line) const {
    return gcs2::OpenAxis(line, {.controller = device.address, .axis = std::to_string(device.axis)},
                          settings, clock);
  }
  Result<std::unique_ptr<Axis>> operator()(const std::shared_ptr<grbl::Machine>& machine) const {
    return grbl::OpenAxis(machine, "XYZA"[device.axis - 1], settings, clock);
  }
};

}  // namespace

Result<std::unique_ptr<Axis>> AxisOpener::Open(const AxisDevice& device,
                                               ControllerAxisSettings settings) {
  settings.scale.zero = device.zero;
  settings.scale.turned = device.turned;
  const Result<Line> line = LineOf(device);
  if (!line) return Error{line.error().code, settings.name + ": " + line.error().message};
  return std::visit(OpenOn{device, settings, clock_}, *line);
}

Result<AxisOpener::Line> AxisOpener::LineOf(const AxisDevice& device) {
  const auto known = lines_.find(device.port.port);
  if (known != lines_.end()) return Shared(known->second, device);
  Result<Line> line = OpenLine(device);
  if (line) lines_.emplace(device.port.port, Opened{device, *line});
  return line;
}

Result<AxisOpener::Line> AxisOpener::Shared(const Opened& opened, const AxisDevice& device) const {
  const char* other = nullptr;
  if (opened.by.protocol != device.protocol) {
    other = "for another protocol";
  } else if (opened.by.port.baud != device.port.baud || opened.by.port.flow != device.port.flow) {
    other = "with another speed or flow control";
  }
  if (other == nullptr) return opened.line;
  return Error{ErrorCode::kRefused,
               fmt::format("{}: another axis has it {}", device.port.port, other)};
}

Result<AxisOpener::Line> AxisOpener::OpenLine(const AxisDevice& device) {
  auto port = device.protocol == AxisProtocol::kApt ? apt::OpenPort(device.port, clock_)
                                                    : SerialPort::Open(device.port);
  if (!port) return port.error();
  std::unique_ptr<ByteLink> link = Logged(std::move(port).value(), log_);
  switch (device.protocol) {
    case AxisProtocol::kZaber:
      return Line(std::make_shared<zaber::Chain>(std::move(link)));
    case AxisProtocol::kSmc100:
      return Line(std::make_shared<smc100::Line>(std::move(link)));
    case AxisProtocol::kApt:
      return Line(std::make_shared<apt::Link>(std::move(link)));
    case AxisProtocol::kEsp301:
      return Line(std::make_shared<esp301::Line>(std::move(link)));
    case AxisProtocol::kGrbl: {
      auto machine = grbl::Machine::Open(std::move(link), clock_, {});
      return machine ? Result<Line>(*machine) : machine.error();
    }
    case AxisProtocol::kGcs2:
      return Line(std::make_shared<gcs2::Line>(std::move(link)));
  }
  GONIO_CHECK(false, "a protocol of AxisProtocol");
}

}  // namespace gonio
