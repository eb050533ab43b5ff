// SPDX-License-Identifier: Apache-2.0
#include "acquisition/failure_policy.h"

namespace gonio {
namespace {

void Read(const ConfigNode& failures, FailureClass failure, FailurePolicy* policy) {
  const char* const key = ToString(failure);
  if (!failures.Has(key)) return;
  const ConfigNode node = failures.Map(key);
  policy->retries = node.IntegerOr("retries", policy->retries, 0, 1000);
  if (failure != FailureClass::kPose) {
    policy->wait = Seconds(node.NumberOr("wait_s", policy->wait.count(), Range::NonNegative()));
  }
  if (!node.Has("then")) return;
  const std::string then = node.Choice("then", {"skip", "pause", "stop"});
  policy->then = then == "skip"    ? FailureAction::kSkip
                 : then == "pause" ? FailureAction::kPause
                                   : FailureAction::kStop;
}

}  // namespace

const char* ToString(FailureClass failure) {
  switch (failure) {
    case FailureClass::kPose:
      return "pose";
    case FailureClass::kInstrument:
      return "instrument";
    case FailureClass::kAxis:
      return "axis";
  }
  return "unknown";
}

const FailurePolicy& FailuresConfig::Of(FailureClass failure) const {
  switch (failure) {
    case FailureClass::kPose:
      return pose;
    case FailureClass::kInstrument:
      return instrument;
    case FailureClass::kAxis:
      return axis;
  }
  return axis;
}

FailuresConfig ReadFailures(const ConfigNode& root) {
  FailuresConfig config;
  if (!root.Has("failures")) return config;
  const ConfigNode node = root.Map("failures");
  Read(node, FailureClass::kPose, &config.pose);
  Read(node, FailureClass::kInstrument, &config.instrument);
  Read(node, FailureClass::kAxis, &config.axis);
  config.max_in_a_row = node.IntegerOr("max_in_a_row", config.max_in_a_row, 1, 1000000);
  return config;
}

FailureBook::Verdict FailureBook::Next(FailureClass failure) {
  ++in_a_row_;
  const FailurePolicy& policy = config_.Of(failure);
  // A skipped pose is told to the planner and logged before the limit is looked at.
  if (TooMany() && policy.then != FailureAction::kSkip) return Verdict::kStop;
  if (!TooMany() && attempts_ < policy.retries) {
    ++attempts_;
    return Verdict::kRetry;
  }
  switch (policy.then) {
    case FailureAction::kSkip:
      return Verdict::kSkip;
    case FailureAction::kPause:
      return Verdict::kPause;
    case FailureAction::kStop:
      return Verdict::kStop;
  }
  return Verdict::kStop;
}

}  // namespace gonio
