// SPDX-License-Identifier: Apache-2.0
// The image of a sample on a sensor: which directions each pixel sees, and how bright it is.

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "brdf/brdf.h"
#include "brdf/imaging.h"
#include "sim/sim_config.h"
#include "sim/sim_image.h"

namespace gonio {

// What one pixel sees of the sample.
//
// The local frame at a surface point: z is the normal, x the sample's x axis projected onto the
// tangent plane (on a cylinder: its axis), y = z cross x. At the two points of a sphere whose
// normal is +x or -x, the local x axis is -z or +z, where it ends on the way there from the top.
struct SurfaceView {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();     // m, in the sample's frame
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   // in the sample's frame
  Eigen::Vector3d tangent = Eigen::Vector3d::UnitX();  // the local x axis, in the sample's frame
  // In the local frame: towards the light and the pinhole. wi below the horizon: in shadow.
  DirectionPair local;
  double inverse_square = 1;  // (light_distance / |light - point|)^2
};

// A pinhole camera and a point light as in brdf/imaging.h, and what a real lens adds.
//
// The image is that of a sensor of sensor_width by sensor_height pixels, whose middle looks at the
// origin; a region of it is the same image, cut out.
//
//   rate(pixel, c) = responsivity_c f_r cos(theta_i) (d_L / |L - p|)^2 power
//                    (1 - vignetting (1 - cos^4 of the field angle))
//
// [electrons/s], blurred by a Gaussian of `defocus`, plus veiling_glare times the mean
// over the region, plus stray_light times power. Background is dark: beyond sample_radius of the
// origin on a plane, beyond it along a cylinder's axis, beside the silhouette. So is what lies in
// shadow. The surfaces are convex: they shade nothing but what turns away from the light. Where the
// sample's reflectance is unknown, pixels are dark.
//
// f_r is not evaluated at each pixel: squares of `every_px` pixels are checked on a lattice of
// three by three and divided where interpolation would err by more than 0.1 %, where the sample's
// edge or a shadow's passes, and where a mirror's highlight may hide. every_px = 1 evaluates all.
// Things that differ over less than every_px / 2 pixels and are none of these may be missed.
class SimOptics {
 public:
  // Preconditions: a finite camera_distance if imaging.resolves_directions(); every_px is a power
  // of two.
  SimOptics(const SimConfig& truth, const Imaging& imaging, int sensor_width, int sensor_height);

  // Of the point (x + 1/2, y + 1/2) on the sensor: pixel x, y. Empty: background.
  std::optional<SurfaceView> See(const SimArms& arms, double x, double y) const;

  // Rates [electrons/s]. `spectrum`: of the light (SpectrumOf). `mono`: one plane. Where imaging
  // does not resolve directions the image is uniform and f_r that of the arms. Not thread-safe.
  SimImage Render(const SimArms& arms, double power, const Brdf& sample, const SimRegion& region,
                  bool mono, const Rgb& spectrum = Rgb::Ones());

  bool resolves_directions() const { return imaging_.resolves_directions(); }

 private:
  class Pose;
  class Renderer;

  Rgb UniformRate(const SimArms& arms, const Rgb& light, const Brdf& sample) const;

  // What the refinement knows of a pixel.
  struct Node {
    std::array<float, 3> rate{};
    float half_x = 0;  // of the half vector, in the local frame
    float half_y = 0;
  };

  const SimConfig truth_;
  const Imaging imaging_;
  const int every_px_;  // 1 of a target, whose edges are sharp
  const int sensor_width_;
  const int sensor_height_;
  // Scratch of Render(), kept because to ask for megabytes takes longer than to fill them.
  std::vector<Node> nodes_;
  std::vector<std::uint8_t> states_;
};

}  // namespace gonio
