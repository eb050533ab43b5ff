// SPDX-License-Identifier: Apache-2.0
// A simulated gonioreflectometer, opened.

#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "brdf/imaging.h"
#include "drivers/axis.h"
#include "drivers/camera.h"
#include "drivers/filter_wheel_light.h"
#include "drivers/light.h"
#include "sim/sim_camera.h"
#include "sim/sim_config.h"

namespace gonio {

// A filter wheel before the lamp.
struct SimWheel {
  AxisLimits limits;
  FilterWheelSettings filters;
};

// What the rig's configuration says of its devices. Axes: in the order of SimAxisNames().
struct SimSetup {
  std::array<AxisLimits, 4> axes;
  Seconds home_limit{120};
  CameraInfo camera;
  Imaging imaging{};   // as built; the simulation's own errors come on top
  double gain_db = 0;  // of the camera
  bool leds = false;   // the light has colours, and no wheel
  std::optional<SimWheel> wheel = std::nullopt;
};

// The devices behind their interfaces, and the machine behind the devices for those who want the
// truth.
struct SimDevices {
  std::array<std::unique_ptr<Axis>, 4> axes;  // null where the rig has none
  std::unique_ptr<Camera> camera;
  std::unique_ptr<Light> light;
  std::unique_ptr<Monitor> monitor;

  // From now on all noise is that of this number, whatever was drawn before: called before each
  // pose, it makes the observations of a session that is resumed those of one that never stopped.
  std::function<void(std::uint64_t)> draw;

  SimMotors motors;
  std::shared_ptr<SimMotor> wheel;  // of filters, if there is one
  std::shared_ptr<SimLamp> lamp;
};

// The lamp that `truth` describes; `seed` is that of the rig.
std::shared_ptr<SimLamp> MakeSimLamp(const SimConfig& truth, std::uint64_t seed);

// Opens a simulated rig that looks at `sample`. Axes start not homed, somewhere in their range; the
// light is off. The same seed and the same calls give the same counts. `sample` and `clock` must
// outlive the devices.
SimDevices MakeSimDevices(const SimConfig& truth, const SimSetup& setup, const Brdf& sample,
                          Clock& clock, std::uint64_t seed);

}  // namespace gonio
