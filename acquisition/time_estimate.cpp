// SPDX-License-Identifier: Apache-2.0
#include "acquisition/time_estimate.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "acquisition/kinematics.h"
#include "acquisition/light_colours.h"
#include "core/check.h"
#include "planner/candidates.h"
#include "planner/sequence_planner.h"

namespace gonio {
namespace {

// Whether row i of an even choice of `share` of all rows is taken.
bool Keeps(int row, double share) {
  return std::floor((row + 1) * share) > std::floor(row * share);
}

}  // namespace

Seconds StandingOf(const RigConfig& rig) {
  return rig.motion.settle + (rig.time_model ? rig.time_model->pose_overhead : Seconds(0));
}

Seconds ReadoutOf(const RigConfig& rig) {
  return rig.camera.readout + (rig.time_model ? rig.time_model->frame_overhead : Seconds(0));
}

TimeEstimate EstimateScan(const RigConfig& rig, std::span<const DirectionPair> poses,
                          Seconds exposing_per_pose) {
  const Kinematics kinematics(rig);
  TimeEstimate estimate;
  std::optional<AxisPositions> at;
  for (const DirectionPair& pair : poses) {
    const std::optional<AxisPositions> target =
        kinematics.Inverse(pair, at.value_or(AxisPositions{}));
    if (!target) continue;
    if (at) estimate.travel += kinematics.TravelTime(*at, *target);
    at = target;
    ++estimate.poses;
    estimate.settling += StandingOf(rig);
    estimate.exposing += exposing_per_pose;
  }
  return estimate;
}

Seconds NominalExposing(const RigConfig& rig) {
  const Seconds exposure =
      std::clamp(rig.dense_exposure, rig.camera.min_exposure, rig.camera.max_exposure);
  const int colours = static_cast<int>(ColoursInTurn(rig).size());
  return colours * rig.dense_brackets * (exposure + ReadoutOf(rig)) + ColourChangesOf(rig);
}

TimeEstimate EstimateDenseScan(const RigConfig& rig, Seconds exposing_per_pose, double keep_rows) {
  GONIO_CHECK(keep_rows > 0 && keep_rows <= 1, "a share of the rows");
  const Kinematics kinematics(rig);
  CandidateOptions options;
  options.phi = IsInPlane(rig.geometry.kind) ? PhiChoice::kInPlane : PhiChoice::kAcross;
  std::vector<Candidate> raster = MakeCandidates(
      options, [&](const DirectionPair& pair) { return kinematics.Reachable(pair); });
  std::erase_if(raster, [&](const Candidate& c) { return !Keeps(c.row, keep_rows); });
  std::vector<DirectionPair> poses;
  for (const int i : RasterOrder(raster, options, {})) poses.push_back(raster[i].directions);
  return EstimateScan(rig, poses, exposing_per_pose);
}

}  // namespace gonio
