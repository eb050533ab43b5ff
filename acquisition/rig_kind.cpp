// SPDX-License-Identifier: Apache-2.0
#include "acquisition/rig_kind.h"

#include <Eigen/Geometry>
#include <cmath>

#include "acquisition/sample_orientation.h"

namespace gonio {
namespace {

constexpr const char* kTurntableNames[] = {"light_arm", "camera_arm", "sample_turn"};
constexpr const char* kTiltingSampleNames[] = {"camera_arm", "sample_turn", "sample_tilt",
                                               "sample_azimuth"};

ArmAngles ArmsOfTurntable(const AxisPositions& axes) {
  const double azimuth = -axes[turntable::kSampleTurn];
  return {azimuth, axes[turntable::kLightArm], azimuth, axes[turntable::kCameraArm]};
}

ArmAngles ArmsOfTiltingSample(const AxisPositions& axes) {
  const Eigen::Matrix3d sample_from_lab = LabFromSample(axes).transpose();
  const double arm = axes[tilting_sample::kCameraArm];
  const Eigen::Vector3d wi = sample_from_lab.col(0);
  const Eigen::Vector3d wo = sample_from_lab * Eigen::Vector3d(std::cos(arm), std::sin(arm), 0);
  const auto azimuth = [](const Eigen::Vector3d& w) { return std::atan2(w.y(), w.x()); };
  const auto elevation = [](const Eigen::Vector3d& w) {
    return std::atan2(w.z(), std::hypot(w.x(), w.y()));
  };
  return {azimuth(wi), elevation(wi), azimuth(wo), elevation(wo)};
}

}  // namespace

std::span<const char* const> AxisNames(RigKind kind) {
  switch (kind) {
    case RigKind::kFourAxisArms:
      return kAxisNames;
    case RigKind::kTurntable:
      return kTurntableNames;
    case RigKind::kTiltingSample:
      return kTiltingSampleNames;
  }
  return {};
}

bool MayBeMissing(RigKind kind, int axis) {
  return kind == RigKind::kTiltingSample && axis == tilting_sample::kSampleAzimuth;
}

std::string_view ToString(RigKind kind) {
  switch (kind) {
    case RigKind::kFourAxisArms:
      return "four-axis-arms";
    case RigKind::kTurntable:
      return "turntable";
    case RigKind::kTiltingSample:
      return "tilting-sample";
  }
  return "";
}

RigKind ReadRigKind(const ConfigNode& geometry) {
  if (!geometry.Has("kind")) return RigKind::kFourAxisArms;
  // "four-axis" is what it was called when there was only one.
  const std::string name =
      geometry.Choice("kind", {"four-axis-arms", "turntable", "tilting-sample", "four-axis"});
  if (name == "turntable") return RigKind::kTurntable;
  return name == "tilting-sample" ? RigKind::kTiltingSample : RigKind::kFourAxisArms;
}

bool IsInPlane(RigKind kind) { return kind == RigKind::kTurntable; }

Range AllowedDegrees(RigKind kind, int axis) {
  switch (kind) {
    case RigKind::kFourAxisArms:
      return axis == kLightAzimuth || axis == kCameraAzimuth ? Range::Between(-360, 360)
                                                             : Range::Between(0, 90);
    case RigKind::kTurntable:
      return axis == turntable::kSampleTurn ? Range::Between(-360, 360) : Range::Between(0, 180);
    case RigKind::kTiltingSample:
      return axis == tilting_sample::kSampleTilt ? Range::Between(-90, 90)
                                                 : Range::Between(-360, 360);
  }
  return {};
}

ArmAngles ArmsOf(RigKind kind, const AxisPositions& axes) {
  switch (kind) {
    case RigKind::kFourAxisArms:
      return axes;
    case RigKind::kTurntable:
      return ArmsOfTurntable(axes);
    case RigKind::kTiltingSample:
      return ArmsOfTiltingSample(axes);
  }
  return axes;
}

}  // namespace gonio
