// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_config.h"

#include <algorithm>
#include <bit>

#include "core/units.h"

namespace gonio {
namespace {

Rgb ReadRgb(const ConfigNode& node, const char* key) {
  const auto numbers = node.Numbers(key, kChannels, Range::Positive());
  return {numbers[0], numbers[1], numbers[2]};
}

template <std::size_t kSize>
std::array<double, kSize> NumbersOr0(const ConfigNode& node, const char* key, Range range) {
  std::array<double, kSize> values{};
  if (!node.Has(key)) return values;
  const std::vector<double> read = node.Numbers(key, kSize, range);
  std::copy(read.begin(), read.end(), values.begin());
  return values;
}

int CountAxes(const ConfigNode& root, SimRigKind rig) {
  const auto names = SimAxisNames(rig);
  const bool last = rig != SimRigKind::kTiltingSample || root.Map("axes").Has(names.back());
  return static_cast<int>(names.size()) - (last ? 0 : 1);
}

// A number for each axis of the rig.
SimArms OfAxes(const ConfigNode& node, const char* key, double fallback, Range range,
               const SimConfig& sim) {
  SimArms values{};
  values.fill(fallback);
  if (!node.Has(key)) return values;
  const auto count = static_cast<std::size_t>(sim.axes);
  const std::vector<double> read = node.Numbers(key, count, range);
  std::copy(read.begin(), read.end(), values.begin());
  return values;
}

void ReadLampAndArms(const ConfigNode& node, SimConfig& sim) {
  sim.lamp_flicker = node.NumberOr("lamp_flicker", 0, Range::Between(0, 0.2));
  sim.lamp_fails_at = node.NumberOr("lamp_fails_at_s", 0, Range::NonNegative());
  sim.colour_crosstalk = node.NumberOr("colour_crosstalk", 0, Range::Between(0, 0.3));
  sim.responsivity_drift_per_hour =
      node.NumberOr("responsivity_drift_per_hour", 0, Range::Between(-0.2, 0.2));
  sim.axis_offset = OfAxes(node, "axis_offset_deg", 0, Range::Between(-5, 5), sim);
  for (double& angle : sim.axis_offset) angle = RadFromDeg(angle);
}

void ReadImage(const ConfigNode& node, SimConfig& sim) {
  sim.light_offset = NumbersOr0<3>(node, "light_offset_m", Range::Between(-1, 1));
  sim.sample_radius = node.NumberOr("sample_radius_m", 0, Range::NonNegative());
  sim.vignetting = node.NumberOr("vignetting", 0, Range::Between(0, 1));
  sim.defocus = node.NumberOr("defocus_px", 0, Range::Between(0, 20));
  sim.stray_light = node.NumberOr("stray_light_e_s", 0, Range::NonNegative());
  sim.veiling_glare = node.NumberOr("veiling_glare", 0, Range::Between(0, 1));
  sim.every_px = node.IntegerOr("every_px", 16, 1, 64);
  if (!std::has_single_bit(static_cast<unsigned>(sim.every_px))) {
    node.Fail("every_px", "must be a power of two");
  }
}

void ReadMotors(const ConfigNode& node, SimConfig& sim) {
  if (!node.Has("motors")) return;
  const ConfigNode motors = node.Map("motors");
  const Range factors = Range::Between(0.1, 10);
  sim.speed_factor = OfAxes(motors, "speed_factor", 1, factors, sim);
  sim.acceleration_factor = OfAxes(motors, "acceleration_factor", 1, factors, sim);
  sim.more_overhead = OfAxes(motors, "more_overhead_s", 0, Range::Between(0, 10), sim);
  sim.frame_overhead = motors.NumberOr("frame_overhead_s", 0, Range::Between(0, 10));
}

// `simulation.imaging`: only what differs from the rig's own.
void ReadTrueImaging(const ConfigNode& node, SimConfig& sim) {
  if (!node.Has("imaging")) return;
  const ConfigNode imaging = node.Map("imaging");
  const auto number = [&](const char* key, double unit) {
    return imaging.Has(key) ? std::optional(imaging.Number(key, Range::Positive()) * unit)
                            : std::nullopt;
  };
  sim.focal_length = number("focal_length_px", 1);
  sim.camera_distance = number("camera_distance_mm", 1e-3);
  sim.light_distance = number("light_distance_mm", 1e-3);
  sim.principal_point = NumbersOr0<2>(imaging, "principal_point_px", Range::Between(-500, 500));
  sim.camera_turn = NumbersOr0<3>(imaging, "camera_turn_deg", Range::Between(-5, 5));
  for (double& angle : sim.camera_turn) angle = RadFromDeg(angle);
  sim.radial_distortion = imaging.NumberOr("radial_distortion", 0, Range::Between(-1, 1));
}

// How a calibration's target truly stands on the stage; which one it is, the calibration says.
void ReadTarget(const ConfigNode& node, SimTarget& target) {
  if (!node.Has("target")) return;
  const ConfigNode mounted = node.Map("target");
  target.shift = NumbersOr0<3>(mounted, "shift_mm", Range::Between(-20, 20));
  for (double& length : target.shift) length *= 1e-3;
  target.turn = NumbersOr0<3>(mounted, "turn_deg", Range::Between(-10, 10));
  for (double& angle : target.turn) angle = RadFromDeg(angle);
}

void ReadSensor(const ConfigNode& node, SimConfig& sim) {
  sim.sensor_seed = static_cast<std::uint64_t>(node.IntegerOr("sensor_seed", 1, 0));
  sim.shutter_offset = node.NumberOr("shutter_offset_s", 0, Range::Between(-0.01, 0.01));
  sim.prnu = node.NumberOr("prnu", 0, Range::Between(0, 0.3));
  sim.dsnu = node.NumberOr("dsnu_e", 0, Range::NonNegative());
  sim.dark_spread = node.NumberOr("dark_spread", 0, Range::Between(0, 1));
  sim.hot_pixels = node.NumberOr("hot_pixels", 0, Range::Between(0, 1));
  sim.hot_dark_current = node.NumberOr("hot_dark_current_e_s", 0, Range::NonNegative());
  sim.dark_doubling = node.NumberOr("dark_doubling_c", 0, Range::NonNegative());
  sim.reference_c = node.NumberOr("reference_c", 20, Range::Between(-100, 100));
  if (node.Has("temperature_c")) {
    sim.temperature_c = node.Number("temperature_c", Range::Between(-100, 100));
  }
  // Steeper, a pixel would never reach full scale.
  sim.nonlinearity = node.NumberOr("nonlinearity", 0, Range::Between(-0.2, 0.2));
}

}  // namespace

SimConfig ReadSim(const ConfigNode& root) {
  const ConfigNode node = root.Map("simulation");
  const ConfigNode believed = root.Map("radiometry");
  const auto number = [&](const char* key, Range range) {
    return node.Has(key) ? node.Number(key, range) : believed.Number(key, range);
  };
  SimConfig sim;
  sim.rig = ReadSimRigKind(root);
  sim.axes = CountAxes(root, sim.rig);
  sim.encoder_resolution =
      RadFromDeg(node.NumberOr("encoder_resolution_deg", 0, Range::Between(0, 1)));
  sim.repeatability = RadFromDeg(node.NumberOr("repeatability_deg", 0, Range::Between(0, 1)));
  sim.light_drift_per_hour = node.NumberOr("light_drift_per_hour", 0, Range::Between(-0.2, 0.2));
  sim.monitor_noise = number("monitor_noise", Range::Between(0, 1));
  sim.multiplicative_noise = number("multiplicative_noise", Range::Between(0, 1));
  sim.read_noise = number("read_noise_e", Range::NonNegative());
  sim.dark_current = number("dark_current_e_s", Range::NonNegative());
  sim.full_well = node.NumberOr("full_well_e", 0, Range::NonNegative());
  sim.shot_noise = node.BoolOr("shot_noise", true);
  sim.black_level = node.IntegerOr("black_level_counts", 0, 0, 16384);
  sim.responsivity = ReadRgb(node.Has("responsivity") ? node : believed, "responsivity");
  sim.electrons_per_count = number("electrons_per_count", Range::Positive());
  ReadLampAndArms(node, sim);
  ReadImage(node, sim);
  ReadTrueImaging(node, sim);
  ReadTarget(node, sim.target);
  ReadMotors(node, sim);
  ReadSensor(node, sim);
  return sim;
}

}  // namespace gonio
