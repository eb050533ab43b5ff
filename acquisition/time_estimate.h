// SPDX-License-Identifier: Apache-2.0
// What a scan would take on a rig, without running it.

#pragma once

#include <span>
#include <vector>

#include "acquisition/rig.h"
#include "brdf/direction.h"

namespace gonio {

// Sums over the poses of a scan.
struct TimeEstimate {
  int poses = 0;
  Seconds travel{0};    // the slowest axis of each move, trapezoidal profiles
  Seconds settling{0};  // waiting after each move
  Seconds exposing{0};  // frames and their read-out
  Seconds total() const { return travel + settling + exposing; }
};

// One pose = move + settle + frames x (exposure + read-out). Poses are visited in the order given,
// starting at the first one; those out of reach are left out. Homing is not counted.
//
// `exposure` is the mean exposure of one frame. Take it from a session on the same rig and material
// when there is one; NominalExposure() otherwise.
TimeEstimate EstimateScan(const RigConfig& rig, std::span<const DirectionPair> poses,
                          int frames_per_pose, Seconds exposure);

// 0.3 s, the lab stage preset of the published rigs, clamped to what the camera can do.
Seconds NominalExposure(const RigConfig& rig);

// The dense reference: every reachable pose of the 90 x 90 MERL raster, row by row of theta_h, each
// row in the direction opposite to the last (as anyone would scan), rig.dense_brackets frames each.
// `keep_rows` (0, 1]: the share of theta_h rows, evenly spread: 0.3 is the published decimation.
TimeEstimate EstimateDenseScan(const RigConfig& rig, Seconds exposure, double keep_rows = 1);

}  // namespace gonio
