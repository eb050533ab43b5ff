// SPDX-License-Identifier: Apache-2.0
#include "acquisition/time_estimate.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "acquisition/kinematics.h"
#include "core/check.h"
#include "planner/candidates.h"

namespace gonio {
namespace {

// Whether row i of an even choice of `share` of all rows is taken.
bool Keeps(int row, double share) {
  return std::floor((row + 1) * share) > std::floor(row * share);
}

}  // namespace

TimeEstimate EstimateScan(const RigConfig& rig, std::span<const DirectionPair> poses,
                          int frames_per_pose, Seconds exposure) {
  const Kinematics kinematics(rig);
  TimeEstimate estimate;
  std::optional<ArmAngles> at;
  for (const DirectionPair& pair : poses) {
    const std::optional<ArmAngles> target = kinematics.Inverse(pair, at.value_or(ArmAngles{}));
    if (!target) continue;
    if (at) estimate.travel += kinematics.TravelTime(*at, *target);
    at = target;
    ++estimate.poses;
    estimate.settling += rig.motion.settle;
    estimate.exposing += frames_per_pose * (exposure + rig.camera.readout);
  }
  return estimate;
}

Seconds NominalExposure(const RigConfig& rig) {
  return std::clamp(Seconds(0.3), rig.camera.min_exposure, rig.camera.max_exposure);
}

TimeEstimate EstimateDenseScan(const RigConfig& rig, Seconds exposure, double keep_rows) {
  GONIO_CHECK(keep_rows > 0 && keep_rows <= 1, "a share of the rows");
  const Kinematics kinematics(rig);
  const std::vector<Candidate> raster =
      MakeCandidates({}, [&](const DirectionPair& pair) { return kinematics.Reachable(pair); });
  std::vector<DirectionPair> poses;
  bool backwards = false;
  for (auto row = raster.begin(); row != raster.end();) {
    const auto next =
        std::find_if(row, raster.end(), [&](const Candidate& c) { return c.row != row->row; });
    if (Keeps(row->row, keep_rows)) {
      const auto first = static_cast<std::ptrdiff_t>(poses.size());
      for (auto it = row; it != next; ++it) poses.push_back(it->directions);
      if (backwards) std::reverse(poses.begin() + first, poses.end());
      backwards = !backwards;
    }
    row = next;
  }
  return EstimateScan(rig, poses, rig.dense_brackets, exposure);
}

}  // namespace gonio
