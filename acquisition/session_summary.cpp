// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "acquisition/session.h"
#include "core/error.h"

namespace gonio {

void SessionOptions::Check() const {
  if (max_rejections_in_a_row < 1) {
    throw ConfigError(
        fmt::format("max_rejections_in_a_row: is {}, must be >= 1", max_rejections_in_a_row));
  }
  if (!(max_reference_change > 0)) {
    throw ConfigError(
        fmt::format("max_reference_change: is {}, must be > 0", max_reference_change));
  }
}

const char* ToString(SessionOutcome outcome) {
  switch (outcome) {
    case SessionOutcome::kComplete:
      return "complete";
    case SessionOutcome::kStopped:
      return "stopped";
    case SessionOutcome::kDeviceFault:
      return "device fault";
    case SessionOutcome::kStorageFailed:
      return "storage failed";
  }
  return "unknown";
}

std::vector<BrdfSample> SessionSummary::Samples() const {
  std::vector<BrdfSample> samples;
  for (const SessionPose& pose : poses) {
    samples.insert(samples.end(), pose.samples.begin(), pose.samples.end());
  }
  return samples;
}

}  // namespace gonio
