// SPDX-License-Identifier: Apache-2.0
// Where a measurement's detector and light stand and what shape the sample has: what it takes to
// give each pixel of an image its own pair of directions.

#pragma once

#include <array>
#include <limits>

namespace gonio {

// The sample's surface touches the axes' common point, the origin of the sample's frame, from
// below, with its normal there along z.
struct SampleShape {
  enum class Kind {
    kFlat,      // the plane z = 0
    kSphere,    // of `radius`, about (0, 0, -radius)
    kCylinder,  // of `radius`, about the line y = 0, z = -radius, along x
  };
  Kind kind = Kind::kFlat;
  double radius = 0;  // m, > 0 unless flat
};

// A pinhole camera and a point light, both aimed at the origin.
//
// The camera's pinhole is at camera_distance along the direction of its arm. Column x and row y of
// an image of w by h pixels look along
//
//   focal_length forward + (x + 1/2 - w/2) right + (y + 1/2 - h/2) down
//
// where, of an arm at azimuth a and elevation e, forward = -(cos e cos a, cos e sin a, sin e),
// right =
// (-sin a, cos a, 0), the way of growing azimuth, and down = (sin e cos a, sin e sin a, -cos e),
// the way of sinking elevation. Pixels are square; (0, 0) is the first that is read out.
struct Imaging {
  double focal_length = 0;  // px; 0: every pixel sees the directions of the arms
  double camera_distance = std::numeric_limits<double>::infinity();  // m
  double light_distance = std::numeric_limits<double>::infinity();   // m
  double patch_radius = 0;  // m; of the disc about the origin whose pixels are used; 0: all
  SampleShape shape{};

  // What a calibration finds of a camera (docs/geometry.md, "Calibration"); 0: as above.
  double principal_x = 0;  // px to the right of the image's middle, of the optical axis
  double principal_y = 0;  // px below it
  // rad, of the camera on its arm, about right, down and forward, in this order; its pinhole stays
  std::array<double, 3> camera_turn{};
  // A ray at tan(field angle) = r is seen at focal_length r (1 + radial_distortion r^2) from the
  // principal point.
  double radial_distortion = 0;

  bool resolves_directions() const { return focal_length > 0; }
};

}  // namespace gonio
