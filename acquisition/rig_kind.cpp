// SPDX-License-Identifier: Apache-2.0
#include "acquisition/rig_kind.h"

namespace gonio {
namespace {

constexpr const char* kTurntableNames[] = {"light_arm", "camera_arm", "sample_turn"};

ArmAngles ArmsOfTurntable(const AxisPositions& axes) {
  const double azimuth = -axes[turntable::kSampleTurn];
  return {azimuth, axes[turntable::kLightArm], azimuth, axes[turntable::kCameraArm]};
}

}  // namespace

std::span<const char* const> AxisNames(RigKind kind) {
  switch (kind) {
    case RigKind::kFourAxisArms:
      return kAxisNames;
    case RigKind::kTurntable:
      return kTurntableNames;
  }
  return {};
}

std::string_view ToString(RigKind kind) {
  switch (kind) {
    case RigKind::kFourAxisArms:
      return "four-axis-arms";
    case RigKind::kTurntable:
      return "turntable";
  }
  return "";
}

RigKind ReadRigKind(const ConfigNode& geometry) {
  if (!geometry.Has("kind")) return RigKind::kFourAxisArms;
  // "four-axis" is what it was called when there was only one.
  return geometry.Choice("kind", {"four-axis-arms", "turntable", "four-axis"}) == "turntable"
             ? RigKind::kTurntable
             : RigKind::kFourAxisArms;
}

bool IsInPlane(RigKind kind) { return kind == RigKind::kTurntable; }

Range AllowedDegrees(RigKind kind, int axis) {
  switch (kind) {
    case RigKind::kFourAxisArms:
      return axis == kLightAzimuth || axis == kCameraAzimuth ? Range::Between(-360, 360)
                                                             : Range::Between(0, 90);
    case RigKind::kTurntable:
      return axis == turntable::kSampleTurn ? Range::Between(-360, 360) : Range::Between(0, 180);
  }
  return {};
}

ArmAngles ArmsOf(RigKind kind, const AxisPositions& axes) {
  switch (kind) {
    case RigKind::kFourAxisArms:
      return axes;
    case RigKind::kTurntable:
      return ArmsOfTurntable(axes);
  }
  return axes;
}

}  // namespace gonio
