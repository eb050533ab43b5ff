// SPDX-License-Identifier: Apache-2.0
// The solids that must not touch, as `keep_out:` of a rig file has them (docs/rig-files.md).

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/config.h"

namespace gonio {

// Of an arm: in its own frame, x from the sample's middle along the arm, z towards growing
// elevation, y completing. What does not move: in the sample's frame, z along the normal.
struct SolidPart {
  enum class Shape { kCapsule, kBox };
  Shape shape = Shape::kCapsule;
  // Ends of a capsule's axis, or opposite corners of a box, `from` the lower one; m.
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  Eigen::Vector3d to = Eigen::Vector3d::Zero();
  double radius = 0;  // m, of a capsule
  bool tilts = true;  // with the elevation; else it turns with the azimuth only, as at elevation 0
};

struct KeepOutConfig {
  double margin = 0;  // m, that stays between surfaces
  std::vector<SolidPart> light_arm;
  std::vector<SolidPart> camera_arm;
  std::vector<SolidPart> fixed;
  std::optional<double> max_azimuth_difference;  // rad: of camera and light, by their cables
};

// Throws ConfigError.
KeepOutConfig ReadKeepOut(const ConfigNode& node);

}  // namespace gonio
