// SPDX-License-Identifier: Apache-2.0
// What a planner is told about a rig: the seconds poses take, noise, what an image shows.

#pragma once

#include "acquisition/rig.h"
#include "planner/image_parts.h"
#include "planner/planner.h"

namespace gonio {

// travel: the slowest axis of the move (acquisition/kinematics.h). A pair of directions leaves the
// arms' common azimuth and the side of the mirrored pair open; `from` stands where it would be
// reached soonest from all axes at zero. Only where an azimuth's limits force a detour does a
// session, whose arms come from somewhere else, take another time. Poses out of reach cost nothing.
//
// pose: settling, one frame exposed as a session exposes where it expects this f_r, and its
// read-out. Frames for darker channels, monitor readings and retries are not foreseen.
//
// frame: such a frame and its read-out. max_frames: the rig's, for metering frames included.
//
// Of a light with colours a frame is one in each of them, and a pose has the changes between them.
//
// Each function remembers its last answers: for one thread, and the copies of a function too.
SessionCosts CostsOn(const RigConfig& rig);

// What Reduce() would give as sigma for that frame.
ExpectedNoise NoiseOn(const RigConfig& rig);

// The directions of an image's regions (acquisition/image_regions.h), from an image of at most some
// 64 pixels a side: a planner needs them to a degree. Empty with one sample per image.
PartsOf PartsOn(const RigConfig& rig);

}  // namespace gonio
