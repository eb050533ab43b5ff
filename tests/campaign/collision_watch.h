// SPDX-License-Identifier: Apache-2.0
// Whether the arms of a simulated rig touch anything, by where their motors truly are.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/rig.h"

namespace gonio {

// Knows the solids of the rig file and nothing of the program's own keep-out: capsules are points
// along their axes, 10 mm apart, which tells gaps near zero to better than a millimetre.
class CollisionWatch {
 public:
  explicit CollisionWatch(const RigConfig& rig);

  // Which solids are nearer than `gap` [m] with the arms at `angles`; nullopt: none.
  std::optional<std::string> FindAt(const ArmAngles& angles, double gap) const;

 private:
  struct Ball {
    Eigen::Vector3d at;
    double radius;
  };
  static std::vector<Ball> BallsOf(const std::vector<SolidPart>& parts, double azimuth,
                                   double elevation);

  const KeepOutConfig config_;
};

}  // namespace gonio
