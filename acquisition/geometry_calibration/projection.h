// SPDX-License-Identifier: Apache-2.0
// Where a camera sees a board's corners and the light in a mirror, as functions of what is unknown
// (docs/geometry.md, "Calibration"). Templates, so that the fit can differentiate them; private to
// bundle.cpp.

#pragma once

#include <Eigen/Core>

#include "acquisition/geometry_calibration/bundle.h"
#include "brdf/camera_axes.h"

namespace gonio {

template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <typename T>
using Vector2 = Eigen::Matrix<T, 2, 1>;

// The middle of the image, where the first pixel's middle is 0 [px].
struct Sensor {
  double middle_x = 0;
  double middle_y = 0;
};

// Towards what the arm carries: where T's arm angles are the encoders' plus the offsets.
template <typename T>
Vector3<T> Outward(const T& azimuth, const T& elevation) {
  return -ArmAxes(azimuth, elevation).col(2);
}

template <typename T>
Vector2<T> Project(const T* u, const ArmAngles& arms, const Sensor& sensor,
                   const Vector3<T>& point) {
  const T azimuth = arms[kCameraAzimuth] + u[kCameraAzimuthOffset];
  const T elevation = arms[kCameraElevation] + u[kCameraElevationOffset];
  const Eigen::Matrix<T, 3, 3> axes = ArmAxes(azimuth, elevation) * Turned(u + kCameraTurnX);
  const Vector3<T> seen =
      axes.transpose() * (point - u[kCameraDistance] * Outward(azimuth, elevation));
  const Vector2<T> r(seen.x() / seen.z(), seen.y() / seen.z());
  const T scale = u[kFocalLength] * (T(1) + u[kRadialDistortion] * r.squaredNorm());
  return {scale * r.x() + u[kPrincipalX] + sensor.middle_x,
          scale * r.y() + u[kPrincipalY] + sensor.middle_y};
}

template <typename T>
Vector3<T> OnBoard(const T* u, const Eigen::Vector2d& corner) {
  const T turn[3] = {u[kBoardTiltX], u[kBoardTiltY], T(0)};
  return Turned(turn) * Vector3<T>(T(corner.x()), T(corner.y()), T(0)) +
         Vector3<T>(u[kBoardX], u[kBoardY], u[kBoardZ]);
}

// The light behind the mirror, where the camera sees it.
template <typename T>
Vector3<T> MirroredLight(const T* u, const ArmAngles& arms) {
  const Vector3<T> light =
      u[kLightDistance] * Outward<T>(arms[kLightAzimuth] + u[kLightAzimuthOffset],
                                     arms[kLightElevation] + u[kLightElevationOffset]);
  const T turn[3] = {u[kMirrorTiltX], u[kMirrorTiltY], T(0)};
  const Vector3<T> normal = Turned(turn).col(2);
  const T height = (light - Vector3<T>(T(0), T(0), u[kMirrorZ])).dot(normal);
  return light - T(2) * height * normal;
}

}  // namespace gonio
