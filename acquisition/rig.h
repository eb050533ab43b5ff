// SPDX-License-Identifier: Apache-2.0
// A gonioreflectometer as its configuration describes it, and its opened devices.

#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/calibration/calibration_kind.h"
#include "acquisition/drift.h"
#include "acquisition/failure_policy.h"
#include "acquisition/keep_out_config.h"
#include "acquisition/radiometry/sensor.h"
#include "acquisition/rig_kind.h"
#include "brdf/brdf.h"
#include "brdf/imaging.h"
#include "core/clock.h"
#include "core/config.h"
#include "drivers/axis.h"
#include "drivers/axis_device.h"
#include "drivers/camera.h"
#include "drivers/camera_device.h"
#include "drivers/light.h"
#include "drivers/light_device.h"

namespace gonio {

struct GeometryConfig {
  RigKind kind = RigKind::kFourAxisArms;
  // Smallest angle between the arms as seen from the sample [rad]: nearer, they touch or the camera
  // shadows the light. theta_d below half of it is out of reach.
  double min_separation = 0;
  double max_polar = 0;  // rad, < pi/2: no direction is measured nearer to the horizon
};

struct MotionConfig {
  Seconds settle{0};        // waited after the last axis has arrived
  Seconds home_limit{120};  // time-out of homing one axis, for the driver
  // One after the other in this order, and nothing watches what they pass: arms that can meet are
  // lifted apart first.
  std::vector<int> home_order = {0, 1, 2, 3};  // each of the rig's axes once
  int retries = 2;                             // repeats of a move that ended outside its tolerance
  std::optional<AxisPositions> park;           // where arms may be left, if a user wants that
};

struct ExposureConfig {
  double target_fraction = 0.6;  // of full scale, aimed at for the brightest channel
  double min_fraction = 0.02;    // of full scale: a channel below this wants a longer exposure
  int max_frames = 6;            // per pose, metering included
  // Longer exposures are taken only to lift a channel above min_fraction: on a dark sample the
  // target would cost half a minute a pose, and averaging over the pixels makes up for it.
  Seconds soft_limit{1};
};

// Turns counts into f_r: electrons = responsivity * f_r * cos(theta_i) * light * exposure.
struct RadiometryConfig {
  Rgb responsivity = Rgb::Ones();   // electrons per pixel, per second, per (f_r cos theta_i = 1/sr)
  double electrons_per_count = 1;   // conversion gain
  double read_noise = 0;            // electrons rms, per pixel and frame
  double dark_current = 0;          // electrons per second per pixel
  double multiplicative_noise = 0;  // relative standard deviation of one frame's mean signal
  double monitor_noise = 0;         // relative standard deviation of one monitor reading
};

// How long moves and frames were found to take (`gonio calibrate time`), in place of what the rig
// file says.
struct TimeModel {
  std::array<double, kAxes> max_speed{};       // rad/s
  std::array<double, kAxes> acceleration{};    // rad/s^2
  std::array<Seconds, kAxes> move_overhead{};  // of each move
  Seconds pose_overhead{0};                    // beside settling: monitor readings, talk
  Seconds frame_overhead{0};                   // beside exposure and read-out
};

// A wheel of filters in front of the light or the camera.
struct FilterWheel {
  AxisLimits limits;
  std::optional<AxisDevice> device;   // empty: simulated
  std::array<double, 3> positions{};  // rad, by LightColour
};

struct RigConfig {
  std::string name;
  std::string text;                    // the file as it was read, frozen into the session
  bool simulated = false;              // no part of it is real
  int axis_count = kAxes;              // what is said of axes beyond these means nothing
  std::array<AxisLimits, kAxes> axes;  // soft limits
  std::array<std::optional<AxisDevice>, kAxes> axis_devices;  // empty: simulated
  GeometryConfig geometry;
  KeepOutConfig keep_out;  // empty: only min_separation is looked at
  MotionConfig motion;
  FailuresConfig failures;
  ExposureConfig exposure;
  RadiometryConfig radiometry;
  DriftPolicy drift;              // off: no reference is visited
  CalibrationPolicy calibration;  // without a folder: `radiometry` is all that is known
  LightDevice light_device;
  MonitorDevice monitor_device;
  CameraDevice camera_device;
  double light_level = 1;  // 0 .. 1
  // Relative change of the light from before to after an exposure that is still steady; empty: not
  // looked at.
  std::optional<double> max_light_change;
  // Whether each frame is lit by one colour of the light and stands for that channel alone: only
  // with a mono camera, of which each pixel otherwise stands for all channels alike.
  bool by_colour = false;
  std::optional<ColourChannels> colour_channels;  // of the light's driver; or
  std::optional<FilterWheel> filter_wheel;
  Seconds colour_settle{0};     // waited after each change of colour
  int dense_brackets = 3;       // frames per pose a dense scan would take, for time estimates
  Seconds dense_exposure{0.3};  // of each of them, on average
  CameraInfo camera;
  Imaging imaging;
  int samples_per_image = 1;  // a power of two; more than 1 only where pixels resolve directions
  // True positions of the axes minus their encoders' [rad], and how sure the directions of light
  // and camera are with them [rad]: of a geometry calibration, else unknown.
  AxisPositions axis_offsets{};
  std::optional<double> sigma_of_directions;
  std::optional<TimeModel> time_model;  // of a time calibration

  // Of the axes that there are, in their order.
  std::span<const char* const> axis_names() const {
    return AxisNames(geometry.kind).first(static_cast<std::size_t>(axis_count));
  }
};

// The opened devices; axes beyond RigConfig::axis_count are null. Destroying them stops the axes
// and switches the light off.
struct Devices {
  std::array<std::unique_ptr<Axis>, kAxes> axes;
  std::unique_ptr<Camera> camera;
  std::unique_ptr<Light> light;
  std::unique_ptr<Monitor> monitor;
};

// What frames of this rig's camera must share with those of a calibration. Full scale is the rig's:
// a sensor may be full before its converter is. `identity`: Camera::identity().
SensorFormat SensorFormatOf(const RigConfig& rig, const std::string& identity);
// What calibrations that depend on the light must share: Light::identity() of a light with colours,
// otherwise empty.
std::string LightFormatOf(const RigConfig& rig, const Light& light);

// Reads the rig part of a rig file such as configs/sim-rig.yaml. Leaves `root` open: the caller
// reads the `simulation` or device part and then calls root.RefuseUnknownKeys(). Throws
// ConfigError.
RigConfig ReadRig(const ConfigNode& root, std::string text);

}  // namespace gonio
