// SPDX-License-Identifier: Apache-2.0
// The kinds of rigs: which axes they have, and how those place light and camera about the sample.

#pragma once

#include <array>
#include <span>
#include <string_view>

#include "core/config.h"

namespace gonio {

// docs/geometry.md draws each.
enum class RigKind {
  kFourAxisArms,   // light and camera on arms with azimuth and elevation; the sample stands still
  kTurntable,      // both arms move in one vertical plane; the sample turns about its normal
  kTiltingSample,  // the light stands still, the camera goes round the sample in a horizontal
                   // plane; stages or a robot turn and tilt the sample
};

// The most axes a rig has. Arrays of axes are this long; what a kind does not have is 0.
inline constexpr int kAxes = 4;

// Positions of a rig's axes [rad], in the order of AxisNames().
using AxisPositions = std::array<double, kAxes>;

// Where the arms are in the sample's frame [rad], whatever moves: AxisIndex order. On a rig of
// four-axis arms these are the positions of its axes; elsewhere ArmsOf() makes them from those.
using ArmAngles = std::array<double, kAxes>;
enum AxisIndex { kLightAzimuth, kLightElevation, kCameraAzimuth, kCameraElevation };
inline constexpr const char* kAxisNames[kAxes] = {"light_azimuth", "light_elevation",
                                                  "camera_azimuth", "camera_elevation"};

namespace turntable {
enum Axis { kLightArm, kCameraArm, kSampleTurn };
}
namespace tilting_sample {
enum Axis { kCameraArm, kSampleTurn, kSampleTilt, kSampleAzimuth };  // the last is not everywhere
}

// In rig files, messages and logs: all that such a rig may have.
std::span<const char* const> AxisNames(RigKind kind);
// Only the last axis of a tilting sample may be missing.
bool MayBeMissing(RigKind kind, int axis);

// "four-axis-arms", "turntable", "tilting-sample".
std::string_view ToString(RigKind kind);
// `kind` of a rig file's `geometry`; four-axis-arms if it is not there. Throws ConfigError.
RigKind ReadRigKind(const ConfigNode& geometry);

// Whether both directions always lie in one plane with the normal: phi_d is then 0 or 180 deg.
bool IsInPlane(RigKind kind);

// What min_deg and max_deg of an axis must be within.
Range AllowedDegrees(RigKind kind, int axis);

// The arms' angles in the sample's frame at these positions of the axes. A turntable's elevations
// go beyond 90 deg, over the zenith, so that a camera's image keeps its way up.
ArmAngles ArmsOf(RigKind kind, const AxisPositions& axes);

}  // namespace gonio
