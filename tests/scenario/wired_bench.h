// SPDX-License-Identifier: Apache-2.0
// A rig whose arms are controllers at the ends of serial lines, through the real drivers and the
// real serial library, in simulated time.

#pragma once

#include "drivers/axis_opener.h"
#include "sim/wire_bench.h"
#include "tests/scenario/bench.h"

namespace gonio {

inline AxisDevice Device(AxisProtocol protocol, const std::string& port, int address = 1) {
  AxisDevice device;
  device.protocol = protocol;
  device.port.port = port;
  if (protocol == AxisProtocol::kSmc100) device.port.flow = SerialSettings::Flow::kXonXoff;
  device.address = address;
  return device;
}

// Bench (sim-rig.yaml), its axes in exchange for controllers: two Zaber stages on one line, an
// SMC100 that is mounted the other way round, and one with its zero elsewhere.
class WiredBench : public Bench {
 public:
  explicit WiredBench(const SimConfig& truth = Perfect())
      : clock_(std::make_shared<ManualClock>()) {
    axes_ = {Device(AxisProtocol::kZaber, "chain", 1), Device(AxisProtocol::kZaber, "chain", 2),
             Device(AxisProtocol::kSmc100, "first"), Device(AxisProtocol::kSmc100, "second")};
    axes_[2].turned = true;
    axes_[3].zero = RadFromDeg(90);
    for (int i = 0; i < kAxes; ++i) doubles_.Add(axes_[i], rig.axes[i]);
    doubles_.Serve();
    wires = std::make_shared<LinkLog>(clock_.get());
    const auto opened = OpenAxes();
    EXPECT_TRUE(opened.ok()) << (opened.ok() ? "" : opened.error().message);
    OpenCamera(truth);
  }

  ~WiredBench() { devices = {}; }  // before their clock and their lines

  // Closes what is open first.
  Result<void> OpenAxes() {
    for (auto& axis : devices.axes) axis.reset();
    AxisOpener opener(clock_.get(), wires);
    for (int i = 0; i < kAxes; ++i) {
      AxisDevice device = axes_[i];
      device.port.port = doubles_.PathOf(i);
      ControllerAxisSettings settings;
      settings.name = kAxisNames[i];
      settings.limits = rig.axes[i];
      auto axis = opener.Open(device, settings);
      if (!axis) return axis.error();
      devices.axes[i] = std::move(axis).value();
    }
    return {};
  }
  // It sees what the axes that are open now say.
  void OpenCamera(const SimConfig& truth) {
    devices.camera = std::make_unique<SimCamera>(
        "camera", rig.camera, truth, sample,
        std::make_unique<ReadbackScene>(Pointers(), devices.light.get()), *clock_, Random(1, 20));
  }

  static SimConfig Perfect() {
    SimConfig truth;
    truth.responsivity = Rgb(100e3, 120e3, 80e3);
    truth.electrons_per_count = 4;
    return truth;
  }
  static const SimConfig& Noisy() {
    static const SimConfig truth =
        ReadSim(ConfigNode::Load(std::string(GONIO_SOURCE_DIR) + "/configs/sim-rig.yaml"));
    return truth;
  }

  SessionSummary Measure(Planner& planner) {
    return RunSession({rig, devices, *clock_, planner, nullptr}, {}, {}, {});
  }
  SessionSummary Measure(std::vector<HalfDiff> poses) {
    ScriptedPlanner planner(std::move(poses));
    return Measure(planner);
  }
  WireBench& doubles() { return doubles_; }
  ManualClock& wire_clock() { return *clock_; }
  PtyServer& line(const std::string& port) { return *doubles_.lines().at(port); }

  std::shared_ptr<LinkLog> wires;

 private:
  std::array<Axis*, kAxes> Pointers() const {
    std::array<Axis*, kAxes> pointers{};
    for (int i = 0; i < kAxes; ++i) pointers[i] = devices.axes[i].get();
    return pointers;
  }

  std::shared_ptr<ManualClock> clock_;
  std::array<AxisDevice, kAxes> axes_;
  WireBench doubles_{clock_};
};

}  // namespace gonio
