// SPDX-License-Identifier: Apache-2.0
// The inside of RunSession() (acquisition/session.h), which alone includes this.

#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "acquisition/failure_policy.h"
#include "acquisition/measure.h"
#include "acquisition/reference_visits.h"
#include "acquisition/session.h"

namespace gonio {

// One session. Methods that return bool say whether it goes on; where they return false it is over,
// and why is in its summary.
class SessionLoop {
 public:
  SessionLoop(const SessionParts& parts, const SessionOptions& options, const SessionStop& stop,
              const ProgressFunction& progress);

  SessionSummary Run();

 private:
  // session_loop.cpp: turn by turn.
  bool Prepare();
  bool StillWanted();  // by the user
  bool Step();
  bool Take(const Proposal& proposal, const PoseRecord& record);
  bool Reject(const Proposal& proposal, const Error& error);
  bool VisitReference();
  bool CheckBracket(const PoseRecord& record);
  void CountTime(const PoseRecord& record);
  Progress CurrentProgress() const;
  int pose_count() const { return static_cast<int>(summary_.poses.size()); }

  // session_trouble.cpp: what comes between.
  bool Pause();
  bool WaitForSurroundings();
  // `before`: where the arms were told to be before the pose, or are.
  bool Discard(const Proposal& proposal, const Trip& trip, const MeasurerState& before);
  bool Suspend(const Trip& trip, const MeasurerState& before);
  bool AwaitClear(const Trip& trip);
  // `proposal`: the pose it happened at, which can be skipped; nullptr: a visit to the reference.
  bool Fail(const Error& error, const MeasurerState& before, const Proposal* proposal);
  bool CallPerson(const std::string& why);
  bool Recover(FailureClass failure, const MeasurerState& before);
  // The reference, as it reads now; none before the first pose.
  Result<std::optional<ReferenceNote>> TryToRecover(FailureClass failure,
                                                    const MeasurerState& before);
  std::optional<Trip> CheckInterlocks();
  // Whether what came of a measurement is the trip's doing: not what the user has stopped, nor a
  // device that failed, unless the trip is worse.
  template <typename T>
  bool Concerns(const Trip& trip, const Result<T>& measured) const {
    if (stop_.now.stop_requested()) return false;
    return measured.ok() || measured.error().code == ErrorCode::kCancelled ||
           measured.error().code == ErrorCode::kRefused || trip.action != TripAction::kSuspend;
  }

  // session_reference.cpp: the last pose, measured again.
  bool GoBack();
  Result<ReferenceNote> ReadReference(const SessionSoFar::Reference& reference);
  // The last pose once more, if there is one, and then all as it was before.
  Result<std::optional<ReferenceNote>> LookBack(const MeasurerState& before);
  // Arms and exposure as they were; kRefused is kProtocol for both.
  Result<void> PutBack(const MeasurerState& before);
  bool Accept(const ReferenceNote& note);

  // session_end.cpp: how it ends.
  bool End(SessionOutcome outcome, std::string reason);
  bool EndWith(const Error& cause);
  void Finish();
  // What of it failed; empty: light off, arms still.
  std::string CleanUp();
  void Park();

  // session_loop.cpp: what everything needs.
  void Enter(SessionSignal signal);
  bool Note(const char* kind, const std::string& message);
  bool Warn(const char* kind, const std::string& message);
  void Draw(std::uint64_t number);
  // Whether `write` succeeded, or there is no log; otherwise the session is over.
  template <typename Write>
  bool Kept(const Write& write) {
    if (parts_.log == nullptr) return true;
    const Result<void> written = write(*parts_.log);
    return written.ok() || End(SessionOutcome::kStorageFailed, written.error().message);
  }

  const SessionParts parts_;
  const SessionOptions options_;
  const SessionStop stop_;
  const ProgressFunction& progress_;
  const Calibrations& calibrations_;
  PoseMeasurer measurer_;
  ReferenceVisits references_;
  FailureBook failures_;
  SessionState state_ = SessionState::kUnhomed;
  bool well_ = true;  // no device has failed that was not opened anew since
  Seconds begin_{0};
  std::uint64_t turn_ = 0;
  std::optional<SessionSoFar::Reference> last_;  // the last measured pose
  SessionSummary summary_;
};

// Stops what is going on when the user says so, or an interlock that is watched while axes move.
// One at a time.
class SessionAbort {
 public:
  SessionAbort(const std::stop_token& user, Interlocks* interlocks);
  ~SessionAbort();
  SessionAbort(const SessionAbort&) = delete;
  SessionAbort& operator=(const SessionAbort&) = delete;

  std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
  Interlocks* const interlocks_;
  std::stop_callback<std::function<void()>> by_user_;
};

}  // namespace gonio
