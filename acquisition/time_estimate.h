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
  Seconds exposing{0};  // frames, their read-out, and changes of the light's colour
  Seconds total() const { return travel + settling + exposing; }
};

// Settling, and what else each pose costs beside its frames; read-out of each frame. By the rig's
// time model if it has one.
Seconds StandingOf(const RigConfig& rig);
Seconds ReadoutOf(const RigConfig& rig);

// One pose = move + settle + exposing. Poses are visited in the order given, starting at the first
// one; those out of reach are left out. Homing is not counted.
//
// `exposing_per_pose`: as above. Take it from a session on the same rig and
// material when there is one; NominalExposing() otherwise.
TimeEstimate EstimateScan(const RigConfig& rig, std::span<const DirectionPair> poses,
                          Seconds exposing_per_pose);

// rig.dense_brackets frames of rig.dense_exposure (0.3 s by default, the lab stage preset of the
// published rigs), clamped to what the camera can do; of a light with colours in each of them.
Seconds NominalExposing(const RigConfig& rig);

// The dense reference, as configs/plan-grid.yaml scans it: every reachable pose of the 90 x 90 MERL
// raster at phi_d = 90 degrees, to and fro. `keep_rows` (0, 1]: the share of theta_h rows, evenly
// spread: 0.3 is the published decimation.
TimeEstimate EstimateDenseScan(const RigConfig& rig, Seconds exposing_per_pose,
                               double keep_rows = 1);

}  // namespace gonio
