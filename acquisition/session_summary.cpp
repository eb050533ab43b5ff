// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "acquisition/session.h"
#include "core/error.h"

namespace gonio {

void SessionOptions::Check() const {
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
    case SessionOutcome::kEmergencyStop:
      return "emergency stop";
  }
  return "unknown";
}

bool IsFault(SessionOutcome outcome) {
  return outcome != SessionOutcome::kComplete && outcome != SessionOutcome::kStopped;
}

std::vector<BrdfSample> SessionSummary::Samples() const {
  std::vector<BrdfSample> samples;
  for (const SessionPose& pose : poses) {
    samples.insert(samples.end(), pose.samples.begin(), pose.samples.end());
  }
  return samples;
}

}  // namespace gonio
