// SPDX-License-Identifier: Apache-2.0
// Axes of what the arms carry, and the ray that a pixel looks along. Templates, so that a fit can
// differentiate them.

#pragma once

#include <Eigen/Core>
#include <cmath>

#include "brdf/imaging.h"

namespace gonio {

// Of an arm [rad]: columns right, down and forward, as in brdf/imaging.h.
template <typename T>
Eigen::Matrix<T, 3, 3> ArmAxes(const T& azimuth, const T& elevation) {
  using std::cos, std::sin;
  const T ca = cos(azimuth), sa = sin(azimuth), ce = cos(elevation), se = sin(elevation);
  Eigen::Matrix<T, 3, 3> axes;
  axes << -sa, se * ca, -ce * ca,  //
      ca, se * sa, -ce * sa,       //
      T(0), -ce, -se;
  return axes;
}

// Rx(turn[0]) Ry(turn[1]) Rz(turn[2]): small turns about x, y and z [rad].
template <typename T>
Eigen::Matrix<T, 3, 3> Turned(const T* turn) {
  using std::cos, std::sin;
  Eigen::Matrix<T, 3, 3> x, y, z;
  x << T(1), T(0), T(0), T(0), cos(turn[0]), -sin(turn[0]), T(0), sin(turn[0]), cos(turn[0]);
  y << cos(turn[1]), T(0), sin(turn[1]), T(0), T(1), T(0), -sin(turn[1]), T(0), cos(turn[1]);
  z << cos(turn[2]), -sin(turn[2]), T(0), sin(turn[2]), cos(turn[2]), T(0), T(0), T(0), T(1);
  return x * y * z;
}

// Columns right, down and forward of the camera, which is turned on its arm.
inline Eigen::Matrix3d CameraAxes(const Imaging& imaging, double azimuth, double elevation) {
  return ArmAxes(azimuth, elevation) * Turned(imaging.camera_turn.data());
}

// To the right, down and forward, of length focal_length along the optical axis. x and y: pixels
// from the image's middle.
inline Eigen::Vector3d PixelRay(const Imaging& imaging, double x, double y) {
  const double f = imaging.focal_length;
  const Eigen::Vector2d distorted =
      Eigen::Vector2d(x, y) - Eigen::Vector2d(imaging.principal_x, imaging.principal_y);
  Eigen::Vector2d straight = distorted;
  // Converges as fast as the distortion is small; 5 times suffice for a tenth at the edge.
  for (int i = 0; i < 5 && imaging.radial_distortion != 0; ++i) {
    straight = distorted / (1 + imaging.radial_distortion * straight.squaredNorm() / (f * f));
  }
  return {straight.x(), straight.y(), f};
}

}  // namespace gonio
