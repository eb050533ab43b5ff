// SPDX-License-Identifier: Apache-2.0
// The default simulated rig, opened and ready to be measured with.

#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "acquisition/measure.h"
#include "core/units.h"
#include "sim/sim_rig.h"

namespace gonio {

inline const char* const kSimRigFile = GONIO_SOURCE_DIR "/configs/sim-rig.yaml";

// Read once: some tests open a thousand rigs.
inline RigConfig DefaultRig() {
  static const RigConfig rig = ReadRig(ConfigNode::Load(kSimRigFile), "");
  return rig;
}
inline SimConfig DefaultTruth() {
  static const SimConfig truth = ReadSim(ConfigNode::Load(kSimRigFile));
  return truth;
}

// A mono camera in front of three LEDs.
inline const char* const kLedRigFile = GONIO_SOURCE_DIR "/configs/sim-rig-leds.yaml";
inline RigConfig LedRig() {
  static const RigConfig rig = ReadRig(ConfigNode::Load(kLedRigFile), "");
  return rig;
}
// The same with a wheel of filters in place of the LEDs.
inline RigConfig WheelRig() {
  RigConfig rig = LedRig();
  rig.colour_channels.reset();
  rig.filter_wheel = FilterWheel{.limits = {.min_position = 0,
                                            .max_position = 5,
                                            .max_speed = 2,
                                            .acceleration = 8,
                                            .position_tolerance = RadFromDeg(0.1)},
                                 .device = {},
                                 .positions = {0.5, 2, 4}};
  return rig;
}

inline SimSetup SetupOf(const RigConfig& rig) {
  SimSetup setup{.axes = rig.axes,
                 .home_limit = rig.motion.home_limit,
                 .camera = rig.camera,
                 .imaging = rig.imaging};
  setup.leds = rig.colour_channels.has_value();
  if (rig.filter_wheel) {
    setup.wheel = SimWheel{
        .limits = rig.filter_wheel->limits,
        .filters = {.positions = rig.filter_wheel->positions, .retries = rig.motion.retries}};
  }
  return setup;
}

// The same f_r everywhere above the horizon.
class FlatBrdf final : public Brdf {
 public:
  explicit FlatBrdf(const Rgb& f_r) : f_r_(f_r) {}
  std::optional<Rgb> Eval(const HalfDiff&) const override { return f_r_; }
  std::string name() const override { return "flat"; }

 private:
  Rgb f_r_;
};

inline DirectionPair PairAt(double theta_h_deg, double theta_d_deg, double phi_d_deg = 90) {
  return ToDirections({.theta_h = RadFromDeg(theta_h_deg),
                       .theta_d = RadFromDeg(theta_d_deg),
                       .phi_d = RadFromDeg(phi_d_deg)});
}

// The axis positions that point the arms at these polar angles and azimuths [deg].
inline ArmAngles AnglesDeg(double light_azimuth, double light_elevation, double camera_azimuth,
                           double camera_elevation) {
  return {RadFromDeg(light_azimuth), RadFromDeg(light_elevation), RadFromDeg(camera_azimuth),
          RadFromDeg(camera_elevation)};
}

class SimulatedRig {
 public:
  explicit SimulatedRig(const Brdf& sample, std::uint64_t seed = 1,
                        const RigConfig& config = DefaultRig(),
                        const SimConfig& truth = DefaultTruth(), Seconds begin = Seconds(0))
      : clock(begin), rig(config) {
    SimDevices sim = MakeSimDevices(truth, SetupOf(rig), sample, clock, seed);
    devices.axes = std::move(sim.axes);
    devices.camera = std::move(sim.camera);
    devices.light = std::move(sim.light);
    devices.monitor = std::move(sim.monitor);
    motors = sim.motors;
    wheel = sim.wheel;
    draw = sim.draw;
    lamp = sim.lamp;
  }

  PoseMeasurer Prepared() {
    PoseMeasurer measurer(rig, devices, clock);
    const auto prepared = measurer.Prepare({});
    EXPECT_TRUE(prepared.ok()) << (prepared.ok() ? "" : prepared.error().message);
    return measurer;
  }

  ManualClock clock;
  std::function<void(std::uint64_t)> draw;
  RigConfig rig;
  Devices devices;
  SimMotors motors;
  std::shared_ptr<SimMotor> wheel;
  std::shared_ptr<SimLamp> lamp;
};

}  // namespace gonio
