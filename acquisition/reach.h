// SPDX-License-Identifier: Apache-2.0
// Which poses a rig can measure, and what keeps it from the others.

#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "acquisition/path_planner.h"

namespace gonio {

enum class Reach {
  kMeasurable,
  kLimits,   // of the axes, max_polar, or min_separation
  kKeepOut,  // every position that realises it is too near to something
  kCutOff,   // it stands free, but there is no way to it from most others
};

struct ReachMap {
  std::vector<Reach> poses;          // as given
  std::map<std::string, int> blame;  // "light_arm 1, fixed 1" -> poses that they keep the rig from
  int Count(Reach reach) const;
};

// Takes some tenths of a millisecond per pose with the arms of configs/rig-solid-arms.yaml.
ReachMap MapReach(const RigConfig& rig, std::span<const DirectionPair> poses);

}  // namespace gonio
