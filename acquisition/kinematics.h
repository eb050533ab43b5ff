// SPDX-License-Identifier: Apache-2.0
// From direction pairs to axis positions and back.

#pragma once

#include <optional>
#include <vector>

#include "acquisition/rig.h"
#include "brdf/direction.h"

namespace gonio {

// Four-axis rig: each arm is set by azimuth (about the sample normal) and elevation (from the
// sample plane; pi/2 = along the normal). docs/geometry.md has the drawing.
class Kinematics {
 public:
  explicit Kinematics(const RigConfig& rig);

  // Where the arms point at these axis positions, which are those of the encoders; the rig's
  // axis_offsets come on top.
  DirectionPair Forward(const ArmAngles& encoders) const;
  // The arms' angles in the sample's frame.
  ArmAngles TrueAngles(ArmAngles encoders) const;

  // Axis positions that realise `pair` for an isotropic sample: turning both azimuths together and
  // mirroring the pair in a plane through the normal change nothing, so among those solutions
  // inside the limits the one that is reached soonest from `from` is returned. nullopt: out of
  // reach.
  std::optional<ArmAngles> Inverse(const DirectionPair& pair, const ArmAngles& from) const;

  // The same, all that are inside the limits and worth a look, the soonest first: for those whom
  // something stands in the way of. Empty: out of reach.
  std::vector<ArmAngles> Solutions(const DirectionPair& pair, const ArmAngles& from) const;

  // Whether Inverse() would find a solution, from anywhere.
  bool Reachable(const DirectionPair& pair) const;

  // Time for all axes to get from one position to another, moving together; the slowest axis
  // decides. Without settling. By the rig's time model if it has one.
  Seconds TravelTime(const ArmAngles& from, const ArmAngles& to) const;

 private:
  bool Allowed(const DirectionPair& pair) const;
  template <typename Visit>
  void VisitSolutions(const DirectionPair& pair, const ArmAngles& from_encoders,
                      const Visit& visit) const;

  std::array<AxisLimits, kAxes> limits_;  // of targets, in true angles
  ArmAngles offsets_{};
  GeometryConfig geometry_;
};

}  // namespace gonio
