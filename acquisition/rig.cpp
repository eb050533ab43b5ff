// SPDX-License-Identifier: Apache-2.0
#include "acquisition/rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "core/units.h"
#include "drivers/move_time.h"

namespace gonio {
namespace {

// min_deg and max_deg, which must be in order.
void ReadSpan(const ConfigNode& node, Range allowed, AxisLimits& limits) {
  const double min = node.Number("min_deg", allowed);
  const double max = node.Number("max_deg", allowed);
  if (max <= min) node.Fail("max_deg", fmt::format("is {}, must be > min_deg = {}", max, min));
  limits.min_position = RadFromDeg(min);
  limits.max_position = RadFromDeg(max);
}

// Targets stay so far inside the limits that the way there does, too.
double ReadApproach(const ConfigNode& node, const AxisLimits& limits) {
  const double approach = RadFromDeg(node.NumberOr("approach_deg", 0, Range::Between(-20, 20)));
  if (std::abs(approach) < limits.max_position - limits.min_position) return approach;
  node.Fail("approach_deg", "leaves no room between min_deg and max_deg");
}

AxisLimits ReadAxis(const ConfigNode& node, Range allowed) {
  AxisLimits limits;
  ReadSpan(node, allowed, limits);
  limits.max_speed = RadFromDeg(node.Number("max_speed_deg_s", Range::Positive()));
  limits.acceleration = RadFromDeg(node.Number("acceleration_deg_s2", Range::Positive()));
  limits.position_tolerance = RadFromDeg(node.Number("tolerance_deg", Range::Positive()));
  limits.approach = ReadApproach(node, limits);
  limits.move_overhead = Seconds(node.NumberOr("move_overhead_s", 0, Range::NonNegative()));
  return limits;
}

void ReadAxes(const ConfigNode& axes, RigConfig& rig) {
  const RigKind kind = rig.geometry.kind;
  rig.axis_count = static_cast<int>(AxisNames(kind).size());
  if (MayBeMissing(kind, rig.axis_count - 1) && !axes.Has(AxisNames(kind).back())) {
    --rig.axis_count;
  }
  for (int i = 0; i < rig.axis_count; ++i) {
    const ConfigNode axis = axes.Map(AxisNames(kind)[static_cast<std::size_t>(i)]);
    rig.axes[i] = ReadAxis(axis, AllowedDegrees(kind, i));
    if (!rig.simulated) rig.axis_devices[i] = ReadAxisDevice(axis.Map("device"));
  }
}

GeometryConfig ReadGeometry(const ConfigNode& node) {
  GeometryConfig geometry;
  geometry.kind = ReadRigKind(node);
  geometry.min_separation = RadFromDeg(node.Number("min_separation_deg", Range::Between(0, 90)));
  geometry.max_polar = RadFromDeg(node.Number("max_polar_deg", Range::Between(1, 89.9)));
  return geometry;
}

std::vector<int> ReadHomeOrder(const ConfigNode& node, std::span<const char* const> axes) {
  const std::vector<std::string> names = node.Texts("home_order");
  std::vector<int> order(axes.size());
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto found = std::find(names.begin(), names.end(), axes[i]);
    if (found == names.end() || names.size() != axes.size()) {
      node.Fail("home_order", fmt::format("must name each of {} once", fmt::join(axes, ", ")));
    }
    order[found - names.begin()] = static_cast<int>(i);
  }
  return order;
}

MotionConfig ReadMotion(const ConfigNode& node, std::span<const char* const> axes) {
  MotionConfig motion;
  motion.home_order.resize(axes.size());
  std::iota(motion.home_order.begin(), motion.home_order.end(), 0);
  motion.settle = Seconds(node.Number("settle_s", Range::NonNegative()));
  motion.home_limit =
      Seconds(node.NumberOr("home_limit_s", motion.home_limit.count(), Range::Positive()));
  motion.retries = node.IntegerOr("retries", motion.retries, 0, 10);
  if (node.Has("home_order")) motion.home_order = ReadHomeOrder(node, axes);
  return motion;
}

AxisPositions ReadPark(const ConfigNode& node, const RigConfig& rig) {
  AxisPositions park{};
  for (int i = 0; i < rig.axis_count; ++i) {
    const AxisLimits limits = TargetLimits(rig.axes[i]);
    const Range range =
        Range::Between(DegFromRad(limits.min_position), DegFromRad(limits.max_position));
    park[i] = RadFromDeg(node.Number(rig.axis_names()[static_cast<std::size_t>(i)], range));
  }
  return park;
}

CameraInfo ReadCamera(const ConfigNode& node) {
  CameraInfo camera;
  camera.width = node.Integer("width_px", 1, 16384);
  camera.height = node.Integer("height_px", 1, 16384);
  camera.full_scale = node.Integer("full_scale_counts", 255, 65535);
  if (node.Has("layout")) camera.layout = ReadPixelLayout(node, "layout");
  const double min = node.Number("min_exposure_s", Range::Positive());
  const double max = node.Number("max_exposure_s", Range::Positive());
  if (max <= min) {
    node.Fail("max_exposure_s", fmt::format("is {}, must be > min_exposure_s = {}", max, min));
  }
  camera.min_exposure = Seconds(min);
  camera.max_exposure = Seconds(max);
  camera.readout = Seconds(node.Number("readout_s", Range::NonNegative()));
  return camera;
}

SampleShape ReadShape(const ConfigNode& node) {
  SampleShape shape;
  const std::string kind = node.Choice("kind", {"flat", "sphere", "cylinder"});
  if (kind == "flat") return shape;
  shape.kind = kind == "sphere" ? SampleShape::Kind::kSphere : SampleShape::Kind::kCylinder;
  shape.radius = node.Number("radius_mm", Range::Positive()) / 1000;
  return shape;
}

// Absent: every pixel sees what the arms say.
void ReadImaging(const ConfigNode& root, RigConfig& rig) {
  if (!root.Has("imaging")) return;
  const ConfigNode node = root.Map("imaging");
  Imaging& imaging = rig.imaging;
  imaging.focal_length = node.Number("focal_length_px", Range::Positive());
  imaging.camera_distance = node.Number("camera_distance_mm", Range::Positive()) / 1000;
  imaging.light_distance = node.Number("light_distance_mm", Range::Positive()) / 1000;
  imaging.patch_radius = node.Number("patch_radius_mm", Range::Positive()) / 1000;
  if (node.Has("sample")) imaging.shape = ReadShape(node.Map("sample"));
  const double nearest = std::min(imaging.camera_distance, imaging.light_distance);
  if (imaging.patch_radius >= nearest) {
    node.Fail("patch_radius_mm", "reaches to the camera or the light");
  }
  rig.samples_per_image = node.IntegerOr("samples_per_image", 1, 1, 1024);
  if ((rig.samples_per_image & (rig.samples_per_image - 1)) != 0) {
    node.Fail("samples_per_image",
              fmt::format("is {}, must be a power of two", rig.samples_per_image));
  }
}

DriftPolicy ReadDrift(const ConfigNode& node, RigKind kind) {
  const bool in_plane = IsInPlane(kind);
  DriftPolicy drift = ReadDriftPolicy(node, in_plane ? 0 : 90);
  if (in_plane && drift.pose && std::abs(std::sin(drift.pose->phi_d)) > 1e-9) {
    node.Map("pose").Fail("phi_d_deg", "must be 0 or 180: the arms of a " +
                                           std::string(ToString(kind)) + " move in one plane");
  }
  return drift;
}

ExposureConfig ReadExposure(const ConfigNode& node) {
  ExposureConfig exposure;
  exposure.target_fraction =
      node.NumberOr("target_fraction", exposure.target_fraction, Range::Between(0.05, 0.95));
  exposure.min_fraction =
      node.NumberOr("min_fraction", exposure.min_fraction, Range::NonNegative());
  if (exposure.min_fraction > exposure.target_fraction / 2) {
    node.Fail("min_fraction", fmt::format("is {}, must be <= half of target_fraction = {}",
                                          exposure.min_fraction, exposure.target_fraction));
  }
  exposure.max_frames = node.IntegerOr("max_frames", exposure.max_frames, 1, 100);
  exposure.soft_limit =
      Seconds(node.NumberOr("soft_limit_s", exposure.soft_limit.count(), Range::Positive()));
  return exposure;
}

RadiometryConfig ReadRadiometry(const ConfigNode& node) {
  RadiometryConfig radiometry;
  radiometry.responsivity =
      Eigen::Map<const Rgb>(node.Numbers("responsivity", kChannels, Range::Positive()).data());
  radiometry.electrons_per_count = node.Number("electrons_per_count", Range::Positive());
  radiometry.read_noise = node.Number("read_noise_e", Range::NonNegative());
  radiometry.dark_current = node.Number("dark_current_e_s", Range::NonNegative());
  radiometry.multiplicative_noise = node.Number("multiplicative_noise", Range::Between(0, 1));
  radiometry.monitor_noise = node.Number("monitor_noise", Range::Between(0, 1));
  return radiometry;
}

FilterWheel ReadFilterWheel(const ConfigNode& node, bool simulated) {
  FilterWheel wheel;
  wheel.limits = ReadAxis(node, Range::Between(-720, 720));
  const AxisLimits allowed = TargetLimits(wheel.limits);
  const ConfigNode positions = node.Map("positions_deg");
  for (std::size_t i = 0; i < wheel.positions.size(); ++i) {
    const char* const name = ToString(kLightColours[i]);
    wheel.positions[i] = RadFromDeg(positions.Number(name));
    if (wheel.positions[i] < allowed.min_position || wheel.positions[i] > allowed.max_position) {
      positions.Fail(name, "is outside min_deg .. max_deg, give or take approach_deg");
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (std::abs(wheel.positions[i] - wheel.positions[k]) > 2 * wheel.limits.position_tolerance) {
        continue;
      }
      positions.Fail(name,
                     fmt::format("is within tolerance_deg of {}", ToString(kLightColours[k])));
    }
  }
  if (!simulated) wheel.device = ReadAxisDevice(node.Map("device"));
  return wheel;
}

// Colours of the light, whichever way it has them. The camera was read before.
void ReadColours(const ConfigNode& light, RigConfig& rig) {
  const bool leds = light.Has("colours");
  const bool wheel = light.Has("filter_wheel");
  rig.by_colour = leds || wheel;
  if (!rig.by_colour) return;
  const char* const key = leds ? "colours" : "filter_wheel";
  if (leds && wheel) light.Fail("filter_wheel", "the light has colours already (light.colours)");
  if (rig.camera.layout != PixelLayout::kMono) {
    light.Fail(key, fmt::format("camera.layout is {}: such a camera tells colours apart by itself "
                                "and wants white light; only one of layout mono is lit by one "
                                "colour after the other",
                                ToString(rig.camera.layout)));
  }
  if (leds) rig.colour_channels = ReadColourChannels(light.Map(key));
  if (wheel) rig.filter_wheel = ReadFilterWheel(light.Map(key), rig.simulated);
  rig.colour_settle = Seconds(light.NumberOr("colour_settle_s", 0, Range::NonNegative()));
}

}  // namespace

SensorFormat SensorFormatOf(const RigConfig& rig, const std::string& identity) {
  SensorFormat format;
  format.camera = identity;
  format.width = rig.camera.width;
  format.height = rig.camera.height;
  format.layout = rig.camera.layout;
  format.full_scale = rig.camera.full_scale;
  if (rig.camera_device.driver != CameraDevice::Driver::kSimulated) {
    format.left = rig.camera_device.genicam.offset_x;
    format.top = rig.camera_device.genicam.offset_y;
    format.gain_db = rig.camera_device.genicam.gain_db;
  }
  return format;
}

std::string LightFormatOf(const RigConfig& rig, const Light& light) {
  return rig.by_colour ? light.identity() : std::string();
}

RigConfig ReadRig(const ConfigNode& root, std::string text) {
  RigConfig rig;
  root.Integer("version", 1, 1);
  rig.name = root.Text("name");
  rig.text = std::move(text);
  rig.simulated = root.Choice("kind", {"simulated", "real"}) == "simulated";
  rig.geometry = ReadGeometry(root.Map("geometry"));
  ReadAxes(root.Map("axes"), rig);
  if (root.Has("keep_out")) {
    rig.keep_out = ReadKeepOut(root.Map("keep_out"), rig.geometry.kind);
  }
  const ConfigNode motion = root.Map("motion");
  rig.motion = ReadMotion(motion, rig.axis_names());
  if (motion.Has("park_deg")) rig.motion.park = ReadPark(motion.Map("park_deg"), rig);
  rig.failures = ReadFailures(root);
  // The least is not zero: without light there is nothing to divide by.
  const ConfigNode camera = root.Map("camera");
  rig.camera = ReadCamera(camera);
  const ConfigNode light = root.Map("light");
  ReadColours(light, rig);
  rig.light_level = light.Number("level", Range::Between(0.001, 1));
  if (light.Has("max_change")) {
    rig.max_light_change = light.Number("max_change", Range::Between(0, 1));
  }
  if (!rig.simulated) {
    rig.light_device = ReadLightDevice(light.Map("device"), rig.colour_channels);
    const ConfigNode monitor = root.Map("monitor");
    rig.monitor_device = ReadMonitorDevice(monitor.Map("device"));
    if (rig.monitor_device.settings.colours.size() > 1 && !rig.by_colour) {
      monitor.Fail("device", "has colours, but the light has none");
    }
    if ((rig.light_device.driver == LightDevice::Driver::kSimulated) !=
        (rig.monitor_device.driver == MonitorDevice::Driver::kSimulated)) {
      monitor.Fail("device", "a simulated monitor sees a simulated light only, and a real a real");
    }
  }
  if (!rig.simulated && camera.Has("device")) {
    rig.camera_device = ReadCameraDevice(camera.Map("device"));
  }
  ReadImaging(root, rig);
  rig.exposure = ReadExposure(root.Map("exposure"));
  rig.radiometry = ReadRadiometry(root.Map("radiometry"));
  if (root.Has("drift")) rig.drift = ReadDrift(root.Map("drift"), rig.geometry.kind);
  if (root.Has("calibration")) {
    rig.calibration = ReadCalibrationPolicy(root.Map("calibration"));
  }
  const ConfigNode time = root.Map("time");
  rig.dense_brackets = time.IntegerOr("dense_brackets", rig.dense_brackets, 1, 100);
  rig.dense_exposure =
      Seconds(time.NumberOr("dense_exposure_s", rig.dense_exposure.count(), Range::Positive()));
  return rig;
}

}  // namespace gonio
