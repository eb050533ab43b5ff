// SPDX-License-Identifier: Apache-2.0
// The default simulated rig, opened and ready to be measured with.

#pragma once

#include <gtest/gtest.h>

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
                        const SimConfig& truth = DefaultTruth())
      : rig(config) {
    SimDevices sim = MakeSimDevices(
        truth, {rig.axes, rig.motion.home_limit, rig.camera, rig.imaging}, sample, clock, seed);
    devices.axes = std::move(sim.axes);
    devices.camera = std::move(sim.camera);
    devices.light = std::move(sim.light);
    devices.monitor = std::move(sim.monitor);
    motors = sim.motors;
    lamp = sim.lamp;
  }

  PoseMeasurer Prepared() {
    PoseMeasurer measurer(rig, devices, clock);
    const auto prepared = measurer.Prepare({});
    EXPECT_TRUE(prepared.ok()) << (prepared.ok() ? "" : prepared.error().message);
    return measurer;
  }

  ManualClock clock;
  RigConfig rig;
  Devices devices;
  SimMotors motors;
  std::shared_ptr<SimLamp> lamp;
};

}  // namespace gonio
