// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sample_orientation.h"

#include <Eigen/Geometry>
#include <cmath>

#include "brdf/camera_axes.h"

namespace gonio {

using Eigen::AngleAxisd, Eigen::Matrix3d, Eigen::Vector3d;

Matrix3d SampleAtZero() {
  Matrix3d columns;
  columns << Vector3d::UnitY(), Vector3d::UnitZ(), Vector3d::UnitX();
  return columns;
}

double CameraRoll(const AxisPositions& axes) {
  const ArmAngles arms = ArmsOf(RigKind::kTiltingSample, axes);
  const Matrix3d arm = ArmAxes(arms[kCameraAzimuth], arms[kCameraElevation]);
  const double at = axes[tilting_sample::kCameraArm];
  const Vector3d right = LabFromSample(axes).transpose() * Vector3d(-std::sin(at), std::cos(at), 0);
  return std::atan2(right.dot(arm.col(1)), right.dot(arm.col(0)));
}

Matrix3d LabFromSample(const AxisPositions& axes) {
  return AngleAxisd(axes[tilting_sample::kSampleTurn], Vector3d::UnitZ()) *
         AngleAxisd(-axes[tilting_sample::kSampleTilt], Vector3d::UnitY()) * SampleAtZero() *
         AngleAxisd(axes[tilting_sample::kSampleAzimuth], Vector3d::UnitZ());
}

}  // namespace gonio
