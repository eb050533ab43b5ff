// SPDX-License-Identifier: Apache-2.0
#include "sim/wire_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/check.h"
#include "core/error.h"
#include "core/units.h"
#include "sim/apt_emulator.h"
#include "sim/esp301_emulator.h"
#include "sim/gcs2_emulator.h"
#include "sim/smc100_emulator.h"
#include "sim/zaber_emulator.h"

namespace gonio {
namespace {

constexpr double kRoom = 10;  // deg, of a stage beyond the rig's limits

// The limits as the controller counts them [deg], with room.
struct Span {
  double least;
  double most;
};
Span SpanOf(const AxisDevice& device, const AxisLimits& limits) {
  const double sign = device.turned ? -1 : 1;
  const auto [least, most] = std::minmax(
      {sign * (limits.min_position - device.zero), sign * (limits.max_position - device.zero)});
  return {DegFromRad(least) - kRoom, DegFromRad(most) + kRoom};
}

ZaberStage ZaberFor(const AxisDevice& device, const AxisLimits& limits) {
  ZaberStage stage;
  stage.device = device.address;
  const double per_degree = static_cast<double>(stage.steps_per_turn) / 360;
  const Span span = SpanOf(device, limits);
  stage.least = std::lround(span.least * per_degree);
  stage.most = std::lround(span.most * per_degree);
  stage.fastest = std::max(stage.fastest, 2 * DegFromRad(limits.max_speed) * per_degree);
  return stage;
}

// A stage of one of the controllers that count in degrees.
template <typename Stage>
Stage Roomy(const AxisDevice& device, const AxisLimits& limits) {
  const Span span = SpanOf(device, limits);
  Stage stage;
  stage.least_deg = span.least;
  stage.most_deg = span.most;
  stage.fastest_deg_s = std::max(stage.fastest_deg_s, 2 * DegFromRad(limits.max_speed));
  return stage;
}

AptStage AptFor(const AxisDevice& device, const AxisLimits& limits) {
  AptStage stage = AptStageOf(device.stage);
  if (device.address > 0) stage.module = static_cast<std::uint8_t>(0x20 + device.address);
  stage.channel = static_cast<std::uint8_t>(device.axis);
  stage.fastest_deg_s = std::max(stage.fastest_deg_s, 2 * DegFromRad(limits.max_speed));
  return stage;
}

}  // namespace

template <typename Emulator, typename Settings>
void WireBench::AddEmulator(const AxisDevice& device, const Settings& settings) {
  auto emulator = std::make_shared<Emulator>(settings, clock_);
  axes_.push_back(
      {.port = device.port.port,
       .angle = [emulator,
                 device] { return device.zero + (device.turned ? -1 : 1) * emulator->Shaft(); },
       .reset = [emulator] { emulator->Reset(); },
       .cut_power = [emulator] { emulator->CutMotorPower(); }});
  controllers_[device.port.port].push_back(
      [emulator](std::string_view bytes) { return emulator->Receive(bytes); });
}

void WireBench::Add(const AxisDevice& device, const AxisLimits& limits) {
  GONIO_CHECK(lines_.empty(), "Add() before Serve()");
  switch (device.protocol) {
    case AxisProtocol::kZaber:
      return AddEmulator<ZaberEmulator>(device, ZaberFor(device, limits));
    case AxisProtocol::kSmc100: {
      auto stage = Roomy<Smc100Stage>(device, limits);
      stage.address = device.address;
      return AddEmulator<Smc100Emulator>(device, stage);
    }
    case AxisProtocol::kApt:
      return AddEmulator<AptEmulator>(device, AptFor(device, limits));
    case AxisProtocol::kEsp301: {
      auto stage = Roomy<Esp301Stage>(device, limits);
      stage.axis = device.axis;
      return AddEmulator<Esp301Emulator>(device, stage);
    }
    case AxisProtocol::kGrbl:
      return AddGrbl(device, limits);
    case AxisProtocol::kGcs2: {
      auto stage = Roomy<Gcs2Stage>(device, limits);
      stage.address = device.address;
      stage.axis = std::to_string(device.axis);
      stage.axes = {stage.axis};
      return AddEmulator<Gcs2Emulator>(device, stage);
    }
  }
}

// Its coordinates end at 0, where the limit switches are.
void WireBench::AddGrbl(const AxisDevice& device, const AxisLimits& limits) {
  std::shared_ptr<Board>& board = boards_[device.port.port];
  if (!board) board = std::make_shared<Board>();
  const int index = device.axis - 1;
  if (index >= GrblBoard::kAxes) {
    throw ConfigError(
        fmt::format("{}: emulated boards have {} axes", device.where, GrblBoard::kAxes));
  }
  auto& settings = board->settings.settings;
  settings[110 + index] = 120 * DegFromRad(limits.max_speed);  // deg/min
  settings[120 + index] = DegFromRad(limits.acceleration);
  settings[130 + index] = -SpanOf(device, limits).least;
  axes_.push_back({.port = device.port.port,
                   .angle =
                       [board, device, index] {
                         return device.zero +
                                (device.turned ? -1 : 1) * board->emulator->Shaft(index);
                       },
                   .reset = [board] { board->emulator->Reset(); },
                   .cut_power = [board] { board->emulator->CutMotorPower(); }});
}

// Everybody on a line hears everything, and those who are meant answer.
void WireBench::Serve() {
  for (const auto& [port, board] : boards_) {
    board->emulator = std::make_shared<GrblEmulator>(board->settings, clock_);
    lines_[port] = Line(port);
  }
  for (const auto& [port, controllers] : controllers_) lines_[port] = Line(port);
}

std::unique_ptr<PtyServer> WireBench::Line(const std::string& port) {
  if (const auto found = boards_.find(port); found != boards_.end()) {
    const std::shared_ptr<Board>& board = found->second;
    return std::make_unique<PtyServer>(
        [board](std::string_view bytes) { return board->emulator->Receive(bytes); },
        [board] { return board->emulator->Unasked(); });
  }
  return std::make_unique<PtyServer>([controllers = controllers_.at(port)](std::string_view bytes) {
    std::string answers;
    for (const Receive& receive : controllers) answers += receive(bytes);
    return answers;
  });
}

const std::string& WireBench::PathOf(std::size_t axis) const {
  return lines_.at(axes_[axis].port)->path();
}

}  // namespace gonio
