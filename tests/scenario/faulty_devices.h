// SPDX-License-Identifier: Apache-2.0
// Devices that fail when a script says so.

#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "acquisition/rig.h"

namespace gonio {

// What a call of a device comes to instead of what it should; empty: nothing. `device` is its name,
// `call` that of the method: "StartMove", "Capture", ...
using FaultScript =
    std::function<std::optional<Error>(const std::string& device, const std::string& call)>;

// Once a call is kDisconnected, so are all others, as drivers/axis.h promises.
class Faults {
 public:
  Faults(std::string device, FaultScript script)
      : device_(std::move(device)), script_(std::move(script)) {}

  std::optional<Error> Of(const std::string& call) {
    if (gone_) return Error{ErrorCode::kDisconnected, device_ + ": is gone"};
    auto fault = script_(device_, call);
    if (fault) fault->message = device_ + ": " + call + ": " + fault->message;
    gone_ = fault && fault->code == ErrorCode::kDisconnected;
    return fault;
  }
  void Replug() { gone_ = false; }

 private:
  const std::string device_;
  const FaultScript script_;
  bool gone_ = false;
};

class FaultyAxis final : public Axis {
 public:
  FaultyAxis(std::unique_ptr<Axis> axis, FaultScript script)
      : axis_(std::move(axis)), faults(axis_->name(), std::move(script)) {}
  const std::string& name() const override { return axis_->name(); }
  const AxisLimits& limits() const override { return axis_->limits(); }
  const std::string& identity() const override { return axis_->identity(); }
  Result<AxisState> State() override {
    if (auto fault = faults.Of("State")) return *fault;
    auto state = axis_->State();
    if (state) state->homed = state->homed && !unhomed_;
    return state;
  }
  Result<void> Home(std::stop_token stop) override {
    if (auto fault = faults.Of("Home")) return *fault;
    auto homed = axis_->Home(std::move(stop));
    if (homed) unhomed_ = false;
    return homed;
  }
  Result<Seconds> StartMove(double position) override {
    if (auto fault = faults.Of("StartMove")) return *fault;
    if (unhomed_) return Error{ErrorCode::kRefused, name() + ": is not homed"};
    return axis_->StartMove(position);
  }
  Result<void> WaitUntilStill(Seconds limit, std::stop_token stop) override {
    if (auto fault = faults.Of("WaitUntilStill")) {
      (void)axis_->Stop();
      // A fault costs the reference; a move that took too long does not.
      unhomed_ = unhomed_ || fault->code != ErrorCode::kTimeout;
      return *fault;
    }
    return axis_->WaitUntilStill(limit, std::move(stop));
  }
  Result<void> Stop() override {
    const auto stopped = axis_->Stop();  // whether it is told or only brakes without a link
    if (auto fault = faults.Of("Stop")) return *fault;
    return stopped;
  }
  Result<void> EmergencyStop() override {
    unhomed_ = true;
    return Stop();
  }

 private:
  const std::unique_ptr<Axis> axis_;
  bool unhomed_ = false;

 public:
  Faults faults;
};

class FaultyCamera final : public Camera {
 public:
  FaultyCamera(std::unique_ptr<Camera> camera, FaultScript script)
      : camera_(std::move(camera)), faults(camera_->name(), std::move(script)) {}
  const std::string& name() const override { return camera_->name(); }
  const std::string& identity() const override { return camera_->identity(); }
  const CameraInfo& info() const override { return camera_->info(); }
  Result<Frame> Capture(Seconds exposure, std::stop_token stop) override {
    if (auto fault = faults.Of("Capture")) return *fault;
    return camera_->Capture(exposure, std::move(stop));
  }

 private:
  const std::unique_ptr<Camera> camera_;

 public:
  Faults faults;
};

class FaultyLight final : public Light {
 public:
  FaultyLight(std::unique_ptr<Light> light, FaultScript script)
      : light_(std::move(light)), faults(light_->name(), std::move(script)) {}
  const std::string& name() const override { return light_->name(); }
  const std::string& identity() const override { return light_->identity(); }
  Result<void> SetLevel(double level) override {
    if (auto fault = faults.Of("SetLevel")) return *fault;
    return light_->SetLevel(level);
  }
  Result<double> Level() override {
    if (auto fault = faults.Of("Level")) return *fault;
    return light_->Level();
  }
  bool has_colours() const override { return light_->has_colours(); }
  Result<void> Select(LightColour colour, std::stop_token stop) override {
    if (auto fault = faults.Of("Select")) return *fault;
    return light_->Select(colour, std::move(stop));
  }
  Result<std::optional<LightColour>> Selected() override {
    if (auto fault = faults.Of("Selected")) return *fault;
    return light_->Selected();
  }

 private:
  const std::unique_ptr<Light> light_;

 public:
  Faults faults;
};

class FaultyMonitor final : public Monitor {
 public:
  FaultyMonitor(std::unique_ptr<Monitor> monitor, FaultScript script)
      : monitor_(std::move(monitor)), faults(monitor_->name(), std::move(script)) {}
  const std::string& name() const override { return monitor_->name(); }
  const std::string& identity() const override { return monitor_->identity(); }
  Result<double> Read() override {
    if (auto fault = faults.Of("Read")) return *fault;
    return monitor_->Read();
  }
  Result<void> Expect(LightColour colour) override { return monitor_->Expect(colour); }

 private:
  const std::unique_ptr<Monitor> monitor_;

 public:
  Faults faults;
};

// Puts them between a session and the devices of a rig.
class FaultyRig {
 public:
  FaultyRig(Devices& devices, const FaultScript& script) {
    for (int i = 0; i < kAxes; ++i) {
      if (!devices.axes[i]) continue;
      auto axis = std::make_unique<FaultyAxis>(std::move(devices.axes[i]), script);
      axes_[i] = &axis->faults;
      devices.axes[i] = std::move(axis);
    }
    instruments_ = {Wrap<FaultyCamera>(devices.camera, script),
                    Wrap<FaultyLight>(devices.light, script),
                    Wrap<FaultyMonitor>(devices.monitor, script)};
  }

  // As SessionParts::reopen: plugs in again what was gone.
  void Reopen(FailureClass failure) {
    if (failure == FailureClass::kAxis) {
      for (Faults* const axis : axes_) {
        if (axis != nullptr) axis->Replug();
      }
    } else {
      for (Faults* const instrument : instruments_) instrument->Replug();
    }
  }

 private:
  template <typename Faulty, typename Device>
  static Faults* Wrap(std::unique_ptr<Device>& device, const FaultScript& script) {
    auto faulty = std::make_unique<Faulty>(std::move(device), script);
    Faults* const faults = &faulty->faults;
    device = std::move(faulty);
    return faults;
  }

  std::array<Faults*, kAxes> axes_{};
  std::array<Faults*, 3> instruments_{};
};

}  // namespace gonio
