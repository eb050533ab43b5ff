// SPDX-License-Identifier: Apache-2.0
#include "planner/image_parts.h"

#include <algorithm>
#include <utility>

namespace gonio {
namespace {

constexpr int kEvery = 4;  // rows and columns of the raster between scouts

}  // namespace

ImageParts::ImageParts(const std::vector<Candidate>& candidates, PartsOf parts)
    : candidates_(candidates), parts_(std::move(parts)) {
  if (!any()) return;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const Candidate& candidate = candidates_[i];
    if (candidate.row % kEvery == 0 && candidate.column % kEvery == 0) {
      scouts_.push_back(static_cast<int>(i));
    }
  }
}

const std::vector<int>& ImageParts::Of(int candidate) const {
  const auto [found, is_new] = known_.try_emplace(candidate);
  std::vector<int>& parts = found->second;
  if (!is_new) return parts;
  parts.push_back(candidate);
  if (!any()) return parts;
  for (const DirectionPair& pair : parts_(candidates_[candidate].directions)) {
    const HalfDiff at = ToHalfDiff(pair);
    const int nearest = NearestCandidate(candidates_, at.theta_h, at.theta_d);
    if (std::find(parts.begin(), parts.end(), nearest) == parts.end()) parts.push_back(nearest);
  }
  return parts;
}

}  // namespace gonio
