// SPDX-License-Identifier: Apache-2.0
// The positions of a rig's axes that realise a pair of directions: the inverse of ArmsOf().

#pragma once

#include <array>
#include <functional>
#include <vector>

#include "acquisition/rig_kind.h"
#include "brdf/direction.h"
#include "drivers/axis.h"

namespace gonio {

// Limits are kept to this much rounding [rad]; far below any encoder's step.
inline constexpr double kLimitRounding = 1e-9;

// Where the axes of a rig may be sent. All of it true positions, not what encoders read.
struct AxisSpace {
  RigKind kind = RigKind::kFourAxisArms;
  std::array<AxisLimits, kAxes> limits{};  // of targets
  // Of the axis that turns the sample about its normal, where it is not only turned because
  // something must be kept away from: rad, tried after where it stands.
  std::vector<double> sample_turns;
};

using VisitAxes = std::function<void(const AxisPositions&)>;

// Hands visit every position inside the limits that is worth a look. The sample is isotropic: both
// azimuths may turn together, and the pair may be mirrored in a plane through the normal. Where
// that leaves an axis free, it is put where it is reached soonest from `from`; of equals those come
// first that move fewer axes. None: out of reach.
//
// Precondition: both directions above the horizon.
void VisitSolutions(const AxisSpace& space, const DirectionPair& pair, const AxisPositions& from,
                    const VisitAxes& visit);

}  // namespace gonio
