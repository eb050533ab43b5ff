// SPDX-License-Identifier: Apache-2.0
// What comes between: pauses, interlocks, failures.

#include <fmt/format.h>

#include "acquisition/session_loop.h"
#include "core/units.h"

namespace gonio {
namespace {

// What no retry mends.
bool IsFinal(ErrorCode code) {
  return code == ErrorCode::kCancelled || code == ErrorCode::kStorage ||
         code == ErrorCode::kEmergencyStop;
}

std::string TextOf(const Proposal& proposal) {
  const HalfDiff at = ToHalfDiff(proposal.directions);
  return fmt::format("candidate {} (theta_h {:.3f}, theta_d {:.3f} deg)", proposal.candidate,
                     DegFromRad(at.theta_h), DegFromRad(at.theta_d));
}

// Requested by either, for as long as it lives.
class EitherStop {
 public:
  EitherStop(const std::stop_token& a, const std::stop_token& b)
      : a_(a, [this] { source_.request_stop(); }), b_(b, [this] { source_.request_stop(); }) {}
  std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
  std::stop_callback<std::function<void()>> a_;
  std::stop_callback<std::function<void()>> b_;
};

}  // namespace

// Between two poses.
bool SessionLoop::Pause() {
  Enter(SessionSignal::kPause);
  Enter(SessionSignal::kPoseDone);
  if (!Note("paused", "by the user; arms and light stay as they are")) return false;
  stop_.wait();
  if (stop_.after_pose.stop_requested() || stop_.now.stop_requested()) return true;
  Enter(SessionSignal::kGoOn);
  return Note("continued", "by the user");
}

std::optional<Trip> SessionLoop::CheckInterlocks() {
  return parts_.interlocks == nullptr ? std::nullopt : parts_.interlocks->Check();
}

// Before anything moves or is lit: what can be seen in the dark.
bool SessionLoop::WaitForSurroundings() {
  if (parts_.interlocks == nullptr) return true;
  const auto trip = parts_.interlocks->CheckSurroundings();
  if (!trip) return true;
  if (trip->action != TripAction::kSuspend) return EndWith(ErrorOf(*trip));
  if (!Warn("waiting", "interlock " + trip->message)) return false;
  const EitherStop stop(stop_.after_pose, stop_.now);
  const auto clear = parts_.interlocks->WaitForSurroundings(stop.token());
  return clear.ok() ? Note("cleared", "all interlocks are met") : EndWith(clear.error());
}

// The planner hears nothing of the pose, and so proposes it again.
bool SessionLoop::Discard(const Proposal& proposal, const Trip& trip, const MeasurerState& before) {
  return Note("pose_discarded", TextOf(proposal) + ": " + trip.message) && Suspend(trip, before);
}

bool SessionLoop::AwaitClear(const Trip& trip) {
  if (trip.action != TripAction::kSuspend) return EndWith(ErrorOf(trip));
  Enter(SessionSignal::kTrip);
  if (!Warn("suspended", "interlock " + trip.message)) return false;
  // A stop after the pose ends it, too: there is no pose.
  const EitherStop stop(stop_.after_pose, stop_.now);
  const auto clear = parts_.interlocks->WaitUntilClear(stop.token());
  if (!clear) return EndWith(clear.error());
  Enter(SessionSignal::kClear);
  return Note("cleared", "all interlocks are met");
}

// Until the interlocks are clear; then the last pose is measured again, to see what has changed.
bool SessionLoop::Suspend(const Trip& trip, const MeasurerState& before) {
  for (std::optional<Trip> next = trip;;) {
    if (!AwaitClear(*next)) return false;
    const auto reference = LookBack(before);
    next = CheckInterlocks();
    if (next && Concerns(*next, reference)) continue;
    if (!reference) return Fail(reference.error(), before, nullptr);
    return !*reference || Accept(**reference);
  }
}

bool SessionLoop::Fail(const Error& error, const MeasurerState& before, const Proposal* proposal) {
  if (IsFinal(error.code)) return EndWith(error);
  const FailureClass failure = error.code == ErrorCode::kRefused ? FailureClass::kPose
                               : measurer_.axes_failed()         ? FailureClass::kAxis
                                                                 : FailureClass::kInstrument;
  const FailureBook::Verdict verdict = failures_.Next(failure);
  if (verdict == FailureBook::Verdict::kStop) return EndWith(error);
  const bool well = failure == FailureClass::kPose;
  well_ = well_ && well;
  if (verdict != FailureBook::Verdict::kSkip || !well) {
    const std::string at = proposal != nullptr ? " at " + TextOf(*proposal) : "";
    if (!Warn("failure", fmt::format("{}{}: {}", ToString(failure), at, error.message))) {
      return false;
    }
  }
  if (verdict == FailureBook::Verdict::kPause) {
    if (!CallPerson(error.message)) return false;
    if (state_ != SessionState::kRunning) return true;  // the user has ended it
  }
  if (!well && !Recover(failure, before)) return false;
  if (verdict != FailureBook::Verdict::kSkip) return true;
  if (proposal != nullptr) return Reject(*proposal, error);
  failures_.Closed();
  return true;
}

// Waits for somebody to look at it; without anybody to wait for, it is the end.
bool SessionLoop::CallPerson(const std::string& why) {
  if (!stop_.wait) return EndWith({ErrorCode::kProtocol, why});
  Enter(SessionSignal::kCall);
  if (!Note("person_called", why)) return false;
  stop_.wait();
  if (stop_.after_pose.stop_requested() || stop_.now.stop_requested()) return true;
  failures_.Closed();
  Enter(SessionSignal::kGoOn);
  return Note("continued", "by the user");
}

// Opens what failed anew, homes the axes if it was one of them, looks at the reference, and puts
// all as it was before the pose; again and again, as the policy has it.
bool SessionLoop::Recover(FailureClass failure, const MeasurerState& before) {
  for (;;) {
    Enter(SessionSignal::kLost);
    parts_.clock.SleepFor(parts_.rig.failures.Of(failure).wait, stop_.now);
    const auto reference = TryToRecover(failure, before);
    if (reference.ok()) {
      Enter(SessionSignal::kOpened);
      well_ = true;
      const bool homed = failure == FailureClass::kAxis;
      return Note("recovered", homed ? "opened anew, every axis homed" : "opened anew") &&
             (!*reference || Accept(**reference));
    }
    const Error& error = reference.error();
    const auto trip =
        parts_.interlocks == nullptr ? std::nullopt : parts_.interlocks->CheckSurroundings();
    if (trip && !stop_.now.stop_requested()) {
      if (!AwaitClear(*trip)) return false;
      continue;
    }
    if (IsFinal(error.code)) return EndWith(error);
    const auto verdict = failures_.Next(failure);
    if (verdict == FailureBook::Verdict::kSkip || verdict == FailureBook::Verdict::kStop) {
      return EndWith(error);
    }
    if (!Warn("failure", fmt::format("{}: {}", ToString(failure), error.message))) return false;
    if (verdict != FailureBook::Verdict::kPause) continue;
    if (!CallPerson(error.message)) return false;
    if (state_ != SessionState::kRunning) return true;  // the user has ended it
  }
}

Result<std::optional<ReferenceNote>> SessionLoop::TryToRecover(FailureClass failure,
                                                               const MeasurerState& before) {
  if (stop_.now.stop_requested()) return Error{ErrorCode::kCancelled, "cancelled"};
  if (parts_.reopen) {
    if (auto opened = parts_.reopen(failure); !opened) return opened.error();
  }
  const Result<void> ready = [&] {
    const SessionAbort abort(stop_.now, parts_.interlocks);
    return failure == FailureClass::kAxis ? measurer_.Prepare(abort.token())
                                          : measurer_.SwitchOn(abort.token());
  }();
  if (!ready) return ready.error();
  return LookBack(before);
}

}  // namespace gonio
