// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_rig.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/sim_axis.h"

namespace gonio {
namespace {

// Streams of the generator; their numbers are part of what makes a seed repeatable.
enum Stream {
  kStart = 0,
  kAxis = 10,
  kCameraStream = 20,
  kMonitorStream = 30,
  kLampStream = 40,
  kWheelStream = 50
};

// Light comes through where the wheel stands at a filter, whatever its encoder says.
SimLamp::Filter FilterOf(std::shared_ptr<const SimMotor> motor, const SimWheel& wheel) {
  return [motor = std::move(motor), wheel](Seconds time) {
    std::optional<LightColour> through;
    if (motor->MovingBetween(time, time)) return through;
    for (const LightColour colour : kLightColours) {
      const double off =
          motor->PositionAt(time) - wheel.filters.positions[static_cast<std::size_t>(colour)];
      if (std::abs(off) <= 2 * wheel.limits.position_tolerance) through = colour;
    }
    return through;
  };
}

std::unique_ptr<SimAxis> MakeWheel(const SimConfig& truth, const SimWheel& wheel,
                                   Seconds home_limit, Clock& clock, std::uint64_t seed,
                                   SimDevices* devices) {
  const AxisLimits& limits = wheel.limits;
  const double place = Random(seed, kWheelStream).Uniform();
  devices->wheel = std::make_shared<SimMotor>(
      limits.min_position + place * (limits.max_position - limits.min_position), limits.max_speed,
      limits.acceleration, clock, limits.move_overhead);
  SimAxisOptions options;
  options.encoder_resolution = truth.encoder_resolution;
  options.repeatability = truth.repeatability;
  options.reference = limits.min_position;
  options.home_limit = home_limit;
  devices->lamp->SetFilter(FilterOf(devices->wheel, wheel), truth.colour_crosstalk);
  return std::make_unique<SimAxis>("filter_wheel", limits, options, devices->wheel, clock,
                                   Random(seed, kWheelStream + 1));
}

// Arms have theirs at opposite ends, so that they are far apart once they are homed; what turns the
// sample has it where it stands straight.
double ReferenceMark(SimRigKind rig, int axis, const AxisLimits& limits) {
  if (rig == SimRigKind::kFourAxisArms) return axis < 2 ? limits.min_position : limits.max_position;
  const std::string_view name = SimAxisNames(rig)[static_cast<std::size_t>(axis)];
  if (name == "light_arm") return limits.min_position;
  if (name == "camera_arm") return limits.max_position;
  return std::clamp(0.0, limits.min_position, limits.max_position);
}

}  // namespace

std::shared_ptr<SimLamp> MakeSimLamp(const SimConfig& truth, std::uint64_t seed) {
  return std::make_shared<SimLamp>(truth.light_drift_per_hour,
                                   SimLamp::Faults{.flicker = truth.lamp_flicker,
                                                   .seed = Random::Hash(seed, kLampStream),
                                                   .fails_at = Seconds(truth.lamp_fails_at)});
}

SimDevices MakeSimDevices(const SimConfig& truth, const SimSetup& setup, const Brdf& sample,
                          Clock& clock, std::uint64_t seed) {
  SimDevices devices;
  devices.lamp = MakeSimLamp(truth, seed);
  const auto names = SimAxisNames(truth.rig).first(static_cast<std::size_t>(truth.axes));
  std::vector<SimAxis*> axes;
  Random start(seed, kStart);
  for (int i = 0; i < std::ssize(names); ++i) {
    const AxisLimits& limits = setup.axes[i];
    const double range = limits.max_position - limits.min_position;
    devices.motors[i] = std::make_shared<SimMotor>(
        limits.min_position + start.Uniform() * range, limits.max_speed * truth.speed_factor[i],
        limits.acceleration * truth.acceleration_factor[i], clock,
        limits.move_overhead + Seconds(truth.more_overhead[i]));
    SimAxisOptions options;
    options.encoder_resolution = truth.encoder_resolution;
    options.repeatability = truth.repeatability;
    options.reference = ReferenceMark(truth.rig, i, limits);
    options.home_limit = setup.home_limit;
    auto axis = std::make_unique<SimAxis>(names[static_cast<std::size_t>(i)], limits, options,
                                          devices.motors[i], clock, Random(seed, kAxis + i));
    axes.push_back(axis.get());
    devices.axes[i] = std::move(axis);
  }
  auto camera = std::make_unique<SimCamera>(
      "camera", setup.camera, truth, sample,
      std::make_unique<MotorScene>(devices.motors, devices.lamp, truth.axis_offset), clock,
      Random(seed, kCameraStream), setup.imaging, setup.gain_db);
  if (setup.leds) devices.lamp->GiveColours(truth.colour_crosstalk);
  devices.light = std::make_unique<SimLight>("light", devices.lamp);
  SimAxis* wheel = nullptr;
  if (setup.wheel) {
    auto axis = MakeWheel(truth, *setup.wheel, setup.home_limit, clock, seed, &devices);
    wheel = axis.get();
    devices.light = std::make_unique<FilterWheelLight>(std::move(devices.light), std::move(axis),
                                                       setup.wheel->filters);
  }
  auto monitor = std::make_unique<SimMonitor>("monitor", devices.lamp, truth.monitor_noise, clock,
                                              Random(seed, kMonitorStream));
  devices.draw = [axes, wheel, seed, c = camera.get(), m = monitor.get()](std::uint64_t number) {
    const std::uint64_t drawn = Random::Hash(seed, number);
    if (wheel != nullptr) wheel->Reseed(Random(drawn, kWheelStream + 1));
    for (int i = 0; i < std::ssize(axes); ++i) axes[i]->Reseed(Random(drawn, kAxis + i));
    c->Reseed(Random(drawn, kCameraStream));
    m->Reseed(Random(drawn, kMonitorStream));
  };
  devices.camera = std::move(camera);
  devices.monitor = std::move(monitor);
  return devices;
}

}  // namespace gonio
