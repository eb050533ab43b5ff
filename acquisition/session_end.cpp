// SPDX-License-Identifier: Apache-2.0
// How a session ends.

#include <fmt/format.h>

#include <utility>

#include "acquisition/session_loop.h"

namespace gonio {
namespace {

// How long clean-up goes on trying, and how often.
constexpr Seconds kCleanUpLimit{30};
constexpr Seconds kCleanUpPause{1};

}  // namespace

// False: the session is over.
bool SessionLoop::End(SessionOutcome outcome, std::string reason) {
  Enter(outcome == SessionOutcome::kEmergencyStop ? SessionSignal::kEmergency
        : IsFault(outcome)                        ? SessionSignal::kFail
                                                  : SessionSignal::kStop);
  summary_.outcome = outcome;
  summary_.reason = std::move(reason);
  return false;
}

bool SessionLoop::EndWith(const Error& cause) {
  const bool by_user = stop_.now.stop_requested() || stop_.after_pose.stop_requested();
  const bool cancelled = cause.code == ErrorCode::kCancelled && !by_user;
  const auto trip = cancelled ? CheckInterlocks() : std::nullopt;
  const Error error = trip ? ErrorOf(*trip) : cause;
  if (error.code == ErrorCode::kEmergencyStop) {
    (void)EmergencyStopAll(parts_.devices).ok();
  } else {
    // Also where the device said kCancelled: it is at rest, the others may not be.
    (void)StopAll(parts_.devices).ok();
  }
  if (error.code == ErrorCode::kCancelled) {
    return End(SessionOutcome::kStopped, "stopped by the user, the arms at once");
  }
  if (!Kept([&](EventLog& log) { return log.AppendError(parts_.clock.Now(), error); })) {
    return false;
  }
  return End(error.code == ErrorCode::kEmergencyStop ? SessionOutcome::kEmergencyStop
                                                     : SessionOutcome::kDeviceFault,
             error.message);
}

void SessionLoop::Finish() {
  const bool clean = summary_.outcome == SessionOutcome::kComplete ||
                     (summary_.outcome == SessionOutcome::kStopped && !stop_.now.stop_requested());
  if (clean && well_ && options_.park) Park();
  const std::string failure = CleanUp();
  if (!failure.empty()) {
    summary_.clean_up_failed = true;
    (void)Warn("clean_up_failed", failure);
    if (!IsFault(summary_.outcome)) End(SessionOutcome::kDeviceFault, failure);
  }
  summary_.duration = parts_.clock.Now() - begin_;
  summary_.gain = references_.At(parts_.clock.Now());
  summary_.predicted_error = parts_.planner.PredictedError();
  if (summary_.outcome != SessionOutcome::kStorageFailed) {
    const SessionEnd end{.outcome = ToString(summary_.outcome),
                         .reason = summary_.reason,
                         .poses = pose_count(),
                         .rejected = summary_.rejected,
                         .duration = summary_.duration,
                         .predicted_error = summary_.predicted_error};
    Kept([&](EventLog& log) { return log.AppendEnd(parts_.clock.Now(), end); });
  }
  Enter(SessionSignal::kCleanedUp);
  if (parts_.on_event) {
    parts_.on_event(
        {"session_end", fmt::format("{}: {}", ToString(summary_.outcome), summary_.reason)});
  }
}

// Tried again until its time is up: a lamp that stays on heats the sample all weekend.
std::string SessionLoop::CleanUp() {
  const Seconds begin = parts_.clock.Now();
  for (;;) {
    std::string failure;
    bool hopeless = false;  // a link that is gone stays so
    const auto add = [&](const char* what, const Result<void>& done) {
      if (done.ok()) return;
      failure += (failure.empty() ? "" : "; ") + (what + done.error().message);
      hopeless = hopeless || done.error().code == ErrorCode::kDisconnected;
    };
    if (parts_.devices.light) {
      add("the light may still be on: ", parts_.devices.light->SetLevel(0));
    } else {
      add("the light may still be on: ", Error{ErrorCode::kDisconnected, "it is not open"});
    }
    if (IsFault(summary_.outcome)) add("an axis may still move: ", StopAll(parts_.devices));
    if (failure.empty() || hopeless) return failure;
    if (parts_.clock.Now() - begin >= kCleanUpLimit || stop_.now.stop_requested()) return failure;
    parts_.clock.SleepFor(kCleanUpPause, stop_.now);
  }
}

// A way to go is found as for every pose. Where it cannot be gone, or somebody stands in the open
// door, the arms stay where they are.
void SessionLoop::Park() {
  if (const auto trip = CheckInterlocks()) {
    (void)Warn("park_failed", "not parked: interlock " + trip->message);
    return;
  }
  const SessionAbort abort(stop_.now, parts_.interlocks);
  const auto parked = measurer_.GoTo(*parts_.rig.motion.park, abort.token());
  if (parked.ok()) {
    (void)Note("parked", "arms stand where motion.park has them");
  } else {
    (void)StopAll(parts_.devices).ok();
    (void)Warn("park_failed", "not parked: " + parked.error().message);
  }
}

}  // namespace gonio
