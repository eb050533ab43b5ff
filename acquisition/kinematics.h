// SPDX-License-Identifier: Apache-2.0
// From direction pairs to positions of the axes and back.

#pragma once

#include <optional>
#include <vector>

#include "acquisition/axis_solutions.h"
#include "acquisition/rig.h"
#include "brdf/direction.h"

namespace gonio {

// The one place that knows where a rig's axes point light and camera, whatever its kind
// (RigConfig::geometry; docs/geometry.md has the drawings). Positions are those of the encoders, in
// the order of the rig's axes, unless it says otherwise.
class Kinematics {
 public:
  explicit Kinematics(const RigConfig& rig);

  // Where the arms point at these positions; the rig's axis_offsets come on top.
  DirectionPair Forward(const AxisPositions& encoders) const;
  // The arms' angles in the sample's frame.
  ArmAngles TrueAngles(const AxisPositions& encoders) const;
  // `imaging` as the camera is held there: one that goes round a tilting sample is upright in the
  // laboratory, and rolls about its axis as the sample sees it.
  Imaging ImagingAt(Imaging imaging, const AxisPositions& encoders) const;
  // Where the axes truly stand.
  AxisPositions TruePositions(AxisPositions encoders) const;

  // Positions that realise `pair` for an isotropic sample: turning both directions together about
  // the normal and mirroring the pair in a plane through it change nothing, so among those
  // solutions inside the limits the one that is reached soonest from `from` is returned. nullopt:
  // out of reach.
  std::optional<AxisPositions> Inverse(const DirectionPair& pair, const AxisPositions& from) const;

  // The same, all that are inside the limits and worth a look, the soonest first: for those whom
  // something stands in the way of. Empty: out of reach.
  std::vector<AxisPositions> Solutions(const DirectionPair& pair, const AxisPositions& from) const;

  // Whether Inverse() would find a solution, from anywhere.
  bool Reachable(const DirectionPair& pair) const;

  // Time for all axes to get from one position to another, moving together; the slowest axis
  // decides. Without settling. By the rig's time model if it has one.
  Seconds TravelTime(const AxisPositions& from, const AxisPositions& to) const;

 private:
  bool Allowed(const DirectionPair& pair) const;
  template <typename Visit>
  void VisitEncoders(const AxisSpace& space, const DirectionPair& pair, const AxisPositions& from,
                     const Visit& visit) const;

  AxisSpace soonest_;  // without detours of the sample, which no pose is reached sooner by
  AxisSpace all_;
  AxisPositions offsets_{};
  GeometryConfig geometry_;
};

}  // namespace gonio
