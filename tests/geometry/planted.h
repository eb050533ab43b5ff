// SPDX-License-Identifier: Apache-2.0
// A rig that is wrong about itself, and what it sees of a board and of a mirror.

#pragma once

#include "acquisition/geometry_calibration/bundle.h"
#include "acquisition/geometry_calibration/target_poses.h"
#include "brdf/analytic.h"
#include "core/units.h"
#include "sim/sim_imager.h"

namespace gonio {

inline constexpr Checkerboard kBoard{9, 6, 0.005};
inline constexpr int kWidth = 640;
inline constexpr int kHeight = 480;

// What the rig believes.
inline RigConfig BelievedRig() {
  RigConfig rig;
  for (int i = 0; i < kAxes; ++i) {
    const bool azimuth = i == kLightAzimuth || i == kCameraAzimuth;
    rig.axes[i] = {.min_position = RadFromDeg(azimuth ? -185 : 2),
                   .max_position = RadFromDeg(azimuth ? 185 : 90),
                   .max_speed = 1,
                   .acceleration = 1,
                   .position_tolerance = 1e-3};
  }
  rig.geometry = {.min_separation = RadFromDeg(3), .max_polar = RadFromDeg(86)};
  rig.camera.width = kWidth;
  rig.camera.height = kHeight;
  rig.camera.layout = PixelLayout::kMono;
  rig.imaging.focal_length = 3000;
  rig.imaging.camera_distance = 0.5;
  rig.imaging.light_distance = 0.6;
  return rig;
}

inline GeometryBelief Belief(const RigConfig& rig) {
  return {rig.imaging, rig.camera.width, rig.camera.height};
}

// The planted values, by GeometryUnknown.
inline SimConfig PlantedTruth() {
  SimConfig truth;
  truth.focal_length = 3060;
  truth.camera_distance = 0.507;
  truth.light_distance = 0.585;
  truth.principal_point = {7, -4};
  truth.camera_turn = {RadFromDeg(0.3), RadFromDeg(-0.2), RadFromDeg(0.5)};
  truth.axis_offset = {RadFromDeg(0.4), RadFromDeg(-0.3), RadFromDeg(0.25), RadFromDeg(0.35)};
  truth.target.turn = {RadFromDeg(0.4), RadFromDeg(-0.3), 0};
  truth.target.shift = {0.0011, -0.0008, 0.0006};
  truth.defocus = 0.7;
  truth.shot_noise = true;
  truth.read_noise = 8;
  truth.responsivity = Rgb::Constant(1e5);
  truth.electrons_per_count = 4;
  truth.black_level = 64;
  return truth;
}

// Of each unknown that both targets share or that is the rig's; the targets stand alike.
inline std::array<double, kGeometryUnknowns> PlantedValues(const SimConfig& t) {
  return {*t.focal_length,   t.principal_point[0], t.principal_point[1], t.radial_distortion,
          t.camera_turn[0],  t.camera_turn[1],     t.camera_turn[2],     t.axis_offset[2],
          t.axis_offset[3],  *t.camera_distance,   t.target.turn[0],     t.target.turn[1],
          t.target.shift[0], t.target.shift[1],    t.target.shift[2],    t.axis_offset[0],
          t.axis_offset[1],  *t.light_distance,    t.target.turn[0],     t.target.turn[1],
          t.target.shift[2]};
}

// Takes images as a session would, with a fixed exposure for each target.
class PlantedRig {
 public:
  PlantedRig(const SimConfig& truth, std::uint64_t seed) : truth_(truth), seed_(seed) {}

  Frame See(SimTarget::Kind kind, const ArmAngles& arms) {
    SimConfig truth = truth_;
    truth.target.kind = kind;
    truth.target.columns = kBoard.columns;
    truth.target.rows = kBoard.rows;
    truth.target.square = kBoard.square;
    SimImager imager(truth, BelievedRig().imaging, kWidth, kHeight, Random(seed_, views_++));
    const bool mirror = kind == SimTarget::Kind::kMirror;
    SimView view{.arms = arms};
    for (int i = 0; i < kAxes; ++i) view.arms[i] += truth.axis_offset[i];
    view.readout = {.exposure = mirror ? Seconds(2e-5) : Seconds(0.2),
                    .gain_db = 0,
                    .black_level = 64,
                    .layout = PixelLayout::kMono,
                    .full_scale = 4095};
    return imager.Expose(view, grey_);
  }

 private:
  const SimConfig truth_;
  const std::uint64_t seed_;
  std::uint64_t views_ = 0;
  const AnalyticBrdf grey_{"grey", {Lambert{}}};
};

}  // namespace gonio
