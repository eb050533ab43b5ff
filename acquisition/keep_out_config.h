// SPDX-License-Identifier: Apache-2.0
// The solids that must not touch, as `keep_out:` of a rig file has them (docs/rig-files.md).

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "acquisition/rig_kind.h"
#include "core/config.h"

namespace gonio {

// Of an arm: in its own frame, x from the sample's middle along the arm, z towards growing
// elevation, y completing. What turns with the sample: in the sample's frame. What does not move:
// in the frame of the machine (docs/geometry.md, "Kinds of rigs").
struct SolidPart {
  enum class Shape { kCapsule, kBox };
  Shape shape = Shape::kCapsule;
  // Ends of a capsule's axis, or opposite corners of a box, `from` the lower one; m.
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  Eigen::Vector3d to = Eigen::Vector3d::Zero();
  double radius = 0;  // m, of a capsule
  // How many of the axes that carry what it belongs to, from the base, turn it; it stands as if the
  // others were at 0. 1 of an arm with azimuth and elevation: a column that does not tilt.
  int axes = kAxes;
};

struct KeepOutConfig {
  double margin = 0;  // m, that stays between surfaces
  std::vector<SolidPart> light_arm;
  std::vector<SolidPart> camera_arm;
  std::vector<SolidPart> sample;  // and what turns with it; empty where it stands still
  std::vector<SolidPart> fixed;
  std::optional<double> max_azimuth_difference;  // rad: of camera and light, by their cables
};

// Throws ConfigError, also for what such a rig does not have.
KeepOutConfig ReadKeepOut(const ConfigNode& node, RigKind kind = RigKind::kFourAxisArms);

}  // namespace gonio
