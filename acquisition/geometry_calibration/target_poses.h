// SPDX-License-Identifier: Apache-2.0
// Where the arms go to look at a calibration's target.

#pragma once

#include <vector>

#include "acquisition/rig.h"

namespace gonio {

// The camera all around the board at elevations from 40 degrees to as high as it gets; the light
// follows at a quarter turn from it, so that the board does not shine. Poses outside the axes'
// limits, beyond max_polar or nearer than min_separation are left out.
std::vector<ArmAngles> BoardPoses(const RigConfig& rig);

// The camera opposite the light, near the mirror's direction and a few degrees to either side of
// it: far enough for the light's distance to show, near enough for its mirror image to stay in the
// picture as far as the rig file knows the lens.
std::vector<ArmAngles> MirrorPoses(const RigConfig& rig);

}  // namespace gonio
