// SPDX-License-Identifier: Apache-2.0
// Where the axes of a simulated rig truly put its light and its camera. The truth has its own
// geometry, so that a mistake in acquisition/kinematics.h cannot hide behind itself.

#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "brdf/direction.h"
#include "core/config.h"

namespace gonio {

// True positions of the axes [rad] in the order of SimAxisNames(); those that a rig does not have
// are 0. Of four-axis arms: light azimuth and elevation, camera azimuth and elevation.
using SimArms = std::array<double, 4>;

enum class SimRigKind { kFourAxisArms, kTurntable, kTiltingSample };

// By `geometry.kind` of a rig file; throws ConfigError.
SimRigKind ReadSimRigKind(const ConfigNode& root);
// All that such a rig may have: the last of a tilting sample, its azimuth, may be missing.
std::span<const char* const> SimAxisNames(SimRigKind kind);

// The axes of what an arm carries, as brdf/imaging.h has them.
struct SimMount {
  Eigen::Vector3d outward = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d right = Eigen::Vector3d::UnitX();
  Eigen::Vector3d down = Eigen::Vector3d::UnitY();
};

// Both in the sample's frame, and how that lies in the machine's: z up, x where the arms of a
// turntable stand at 0 and where the light of a tilting sample is.
struct SimPlacement {
  SimMount light;
  SimMount camera;
  Eigen::Matrix3d sample_from_machine = Eigen::Matrix3d::Identity();

  DirectionPair directions() const { return {light.outward, camera.outward}; }
};

SimPlacement Place(SimRigKind kind, const SimArms& axes);

}  // namespace gonio
