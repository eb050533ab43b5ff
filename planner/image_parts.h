// SPDX-License-Identifier: Apache-2.0
// One image, many samples: which other candidates the image of a candidate measures along with it.

#pragma once

#include <functional>
#include <map>
#include <vector>

#include "planner/candidates.h"

namespace gonio {

// All directions under which the image of a pose shows the sample, the pose's own first: a fan of
// theta_h on a round sample. Its answers depend on its argument only. Injected because a planner
// knows no camera. Empty: an image is one sample.
using PartsOf = std::function<std::vector<DirectionPair>(const DirectionPair&)>;

// One thread. Each part is stood for by the candidate nearest to it in (theta_h, theta_d): what a
// raster of candidates cannot tell apart, a planner does not.
class ImageParts {
 public:
  // `candidates` must outlive it.
  ImageParts(const std::vector<Candidate>& candidates, PartsOf parts);

  bool any() const { return parts_ != nullptr; }
  // The candidate itself first, none twice. Asked for the first time it takes milliseconds.
  const std::vector<int>& Of(int candidate) const;
  // Candidates some degrees apart, whose images are always worth a look: fans are wide, and what a
  // pose's middle would teach says little of them. Empty without parts.
  const std::vector<int>& scouts() const { return scouts_; }

 private:
  const std::vector<Candidate>& candidates_;
  PartsOf parts_;
  std::vector<int> scouts_;
  mutable std::map<int, std::vector<int>> known_;
};

}  // namespace gonio
