// SPDX-License-Identifier: Apache-2.0
#include "acquisition/reach.h"

#include <algorithm>

namespace gonio {
namespace {

// Whether a position of the pair stands free; otherwise who is to blame at the first.
bool StandsFree(const std::vector<AxisPositions>& positions, const Kinematics& kinematics,
                const KeepOut& keep_out, std::string* blame) {
  for (const AxisPositions& at : positions) {
    const auto contact = keep_out.FindAt(kinematics.TruePositions(at));
    if (!contact) return true;
    if (blame->empty()) {
      *blame = contact->second.empty() ? contact->first : contact->first + ", " + contact->second;
    }
  }
  return false;
}

}  // namespace

int ReachMap::Count(Reach reach) const {
  return static_cast<int>(std::count(poses.begin(), poses.end(), reach));
}

ReachMap MapReach(const RigConfig& rig, std::span<const DirectionPair> poses) {
  const Kinematics kinematics(rig);
  const KeepOut keep_out(rig);
  const PathPlanner paths(rig);
  ReachMap map;
  map.poses.assign(poses.size(), Reach::kMeasurable);
  std::vector<DirectionPair> free;
  std::vector<std::size_t> where;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::vector<AxisPositions> positions = kinematics.Solutions(poses[i], AxisPositions{});
    std::string blame;
    if (positions.empty()) {
      map.poses[i] = Reach::kLimits;
    } else if (!StandsFree(positions, kinematics, keep_out, &blame)) {
      map.poses[i] = Reach::kKeepOut;
      ++map.blame[blame];
    } else {
      free.push_back(poses[i]);
      where.push_back(i);
    }
  }
  if (keep_out.empty()) return map;
  const std::vector<bool> connected = paths.Connected(free);
  for (std::size_t k = 0; k < free.size(); ++k) {
    if (!connected[k]) map.poses[where[k]] = Reach::kCutOff;
  }
  return map;
}

}  // namespace gonio
