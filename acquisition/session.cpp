// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "acquisition/bracket_check.h"
#include "acquisition/light_colours.h"
#include "acquisition/measure.h"
#include "acquisition/radiometry.h"
#include "acquisition/reference_visits.h"
#include "core/check.h"
#include "core/units.h"

namespace gonio {
namespace {

// However a session ends, exceptions included, the sample is not left in the light.
class LightOffAtEnd {
 public:
  explicit LightOffAtEnd(Light& light) : light_(light) {}
  ~LightOffAtEnd() { (void)light_.SetLevel(0).ok(); }
  LightOffAtEnd(const LightOffAtEnd&) = delete;
  LightOffAtEnd& operator=(const LightOffAtEnd&) = delete;

 private:
  Light& light_;
};

const Calibrations kNoCalibrations;

// Numbers of draws beyond those of any pose.
constexpr std::uint64_t kReferenceDraws = std::uint64_t{1} << 32;

constexpr std::uint64_t kVisitDraws = std::uint64_t{2} << 32;

// By the channel that is known best.
ReferenceNote Compared(int pose, const BrdfSample& before, const BrdfSample& now) {
  ReferenceNote note{.pose = pose, .before = before, .now = now};
  double best = std::numeric_limits<double>::infinity();
  for (int c = 0; c < kChannels; ++c) {
    const double sigma = std::hypot(before.sigma[c], now.sigma[c]) / std::abs(before.f_r[c]);
    if (!(sigma < best)) continue;
    best = sigma;
    note.change = now.f_r[c] / before.f_r[c] - 1;
    note.sigma_change = sigma;
  }
  return note;
}

// Of the score of two exposures that do not agree: chance does this once in a million pairs.
constexpr double kMismatch = 5;

class Session {
 public:
  Session(const SessionParts& parts, const SessionOptions& options, const SessionStop& stop,
          const ProgressFunction& progress)
      : parts_(parts),
        options_(options),
        stop_(stop),
        progress_(progress),
        calibrations_(parts.calibrations != nullptr ? *parts.calibrations : kNoCalibrations),
        measurer_(parts.rig, parts.devices, parts.clock,
                  calibrations_.bad_pixels ? &calibrations_.bad_pixels->mask : nullptr),
        references_(parts.rig, calibrations_) {
    if (parts.so_far == nullptr) return;
    summary_ = parts.so_far->summary;
    turn_ = parts.so_far->turns;
    rejections_in_a_row_ = parts.so_far->rejections_in_a_row;
    for (const LoggedVisit& visit : parts.so_far->visits) references_.Recall(visit);
    if (parts.so_far->first) references_.Offer(*parts.so_far->first);
    summary_.reference_visits = references_.visits();
    last_ = parts.so_far->reference;
  }

  SessionSummary Run() {
    const LightOffAtEnd light_off(*parts_.devices.light);
    if (parts_.so_far == nullptr) begin_ = parts_.clock.Now();
    if (Prepare() && GoBack()) {
      while (Step()) {
        Enter(SessionSignal::kPoseDone);
        if (progress_) progress_(CurrentProgress());
      }
    }
    Finish();
    return std::move(summary_);
  }

 private:
  void Enter(SessionSignal signal) {
    const std::optional<SessionState> next = After(state_, signal);
    GONIO_CHECK(next.has_value(), "a signal that means nothing in this state");
    state_ = *next;
    if (parts_.on_state) parts_.on_state(state_);
  }

  int pose_count() const { return static_cast<int>(summary_.poses.size()); }

  Progress CurrentProgress() const {
    return {.poses = pose_count(),
            .max_poses = parts_.planner.MaxPoses(),
            .rejected = summary_.rejected,
            .elapsed = parts_.clock.Now() - begin_,
            .predicted_error = parts_.planner.PredictedError()};
  }

  bool Prepare() {
    const Seconds before = parts_.clock.Now();
    const Result<void> prepared = measurer_.Prepare(stop_.now);
    summary_.preparation += parts_.clock.Now() - before;
    if (!prepared.ok()) return EndWith(prepared.error());
    Enter(SessionSignal::kHomed);
    if (!Note("prepared", "every axis homed, light on")) return false;
    Enter(SessionSignal::kStart);
    return true;
  }

  bool Note(const char* kind, const char* message) {
    return Kept([&](EventLog& log) { return log.AppendNote(parts_.clock.Now(), kind, message); });
  }

  // Between two poses. False: the session is over.
  bool Pause() {
    Enter(SessionSignal::kPause);
    Enter(SessionSignal::kPoseDone);
    if (!Note("paused", "by the user; arms and light stay as they are")) return false;
    stop_.wait();
    if (stop_.after_pose.stop_requested() || stop_.now.stop_requested()) return true;
    Enter(SessionSignal::kGoOn);
    return Note("continued", "by the user");
  }

  // After a resume: measures the last pose again, compares, and puts everything as it was then.
  bool GoBack() {
    if (parts_.so_far == nullptr) return true;
    const SessionSoFar& so_far = *parts_.so_far;
    if (so_far.reference && !MeasureReference(*so_far.reference)) return false;
    if (!so_far.measurer) return true;
    const auto restored = measurer_.Restore(*so_far.measurer, stop_.now);
    return restored.ok() || EndWith(restored.error());
  }

  bool MeasureReference(const SessionSoFar::Reference& reference) {
    Draw(kReferenceDraws + turn_);
    const auto record =
        measurer_.MeasureAt(reference.arms, reference.before.f_r, stop_.now, reference.frames);
    if (!record) return EndWith(record.error());
    auto reduced = Reduce(*record, parts_.rig, calibrations_);
    if (!reduced) return EndWith(reduced.error());
    references_.Correct(record->end, &*reduced);
    const ReferenceNote note = Compared(reference.pose, reference.before, reduced->front().sample);
    if (!Kept([&](EventLog& log) { return log.AppendResumeReference(record->end, note); }))
      return false;
    const double change = std::abs(note.change);
    if (!(change > options_.max_reference_change && change > 4 * note.sigma_change)) return true;
    return EndWith({ErrorCode::kProtocol,
                    fmt::format("pose {} reads {:+.1f} % ({:.1f} % standard uncertainty) against "
                                "before the interruption: something has changed",
                                note.pose, 100 * note.change, 100 * note.sigma_change)});
  }

  void Draw(std::uint64_t number) {
    if (parts_.draw) parts_.draw(number);
  }

  // One turn of the loop; false once the session is over.
  bool Step() {
    if (stop_.pause && stop_.pause() && !Pause()) return false;
    if (stop_.now.stop_requested()) {
      return EndWith({ErrorCode::kCancelled, "stopped between poses"});
    }
    if (stop_.after_pose.stop_requested()) {
      return End(SessionOutcome::kStopped, "stopped by the user");
    }
    if (const auto trip = CheckInterlocks()) return Suspend(*trip);
    if (references_.Due(pose_count(), parts_.clock.Now()) && !VisitReference()) return false;
    const std::optional<Proposal> proposal = parts_.planner.Next();
    if (!proposal) return End(SessionOutcome::kComplete, parts_.planner.reason());

    Draw(++turn_);
    const std::optional<Rgb> expected = parts_.planner.Predict(proposal->directions);
    Result<PoseRecord> record =
        measurer_.Measure(proposal->directions, expected, stop_.now, proposal->frames);
    const auto trip = CheckInterlocks();
    const bool by_user = !record.ok() && record.error().code == ErrorCode::kCancelled;
    if (trip && !by_user) return Discard(*proposal, *trip);
    if (record.ok()) return Take(*proposal, *record);
    if (record.error().code == ErrorCode::kRefused) return Reject(*proposal, record.error());
    return EndWith(record.error());
  }

  std::optional<Trip> CheckInterlocks() {
    return parts_.interlocks == nullptr ? std::nullopt : parts_.interlocks->Check();
  }

  // The planner hears nothing of the pose, and so proposes it again.
  bool Discard(const Proposal& proposal, const Trip& trip) {
    --turn_;
    const HalfDiff at = ToHalfDiff(proposal.directions);
    const std::string what =
        fmt::format("candidate {} (theta_h {:.3f}, theta_d {:.3f} deg): {}", proposal.candidate,
                    DegFromRad(at.theta_h), DegFromRad(at.theta_d), trip.message);
    return Note("pose_discarded", what.c_str()) && Suspend(trip);
  }

  // Until the interlocks are clear; then the last pose is measured again, to see what has changed.
  bool Suspend(const Trip& trip) {
    if (trip.stop) return EndWith({ErrorCode::kProtocol, "interlock " + trip.message});
    Enter(SessionSignal::kTrip);
    if (!Warn("suspended", "interlock " + trip.message)) return false;
    // A stop after the pose ends it, too: there is no pose.
    std::stop_source stop;
    const auto request = [&] { stop.request_stop(); };
    const std::stop_callback by_pose(stop_.after_pose, request);
    const std::stop_callback by_now(stop_.now, request);
    const auto clear = parts_.interlocks->WaitUntilClear(stop.get_token());
    if (!clear) return EndWith(clear.error());
    Enter(SessionSignal::kClear);
    if (!Note("cleared", "all interlocks are met")) return false;
    if (!last_) return true;
    const MeasurerState before = measurer_.state();
    if (!MeasureReference(*last_)) return false;
    const auto restored = measurer_.Restore(before, stop_.now);
    return restored.ok() || EndWith(restored.error());
  }

  // Keeps a measured pose, reduces it and tells the planner, in this order.
  bool Take(const Proposal& proposal, const PoseRecord& record) {
    const PoseNote note{pose_count() + 1, proposal, parts_.planner.PredictedError(),
                        measurer_.state()};
    if (!Kept([&](EventLog& log) { return log.AppendPose(note, record); })) return false;
    auto reduced = Reduce(record, parts_.rig, calibrations_);
    if (!reduced) return EndWith(reduced.error());
    if (!CheckBracket(record)) return false;
    references_.Correct(record.end, &*reduced);
    references_.Offer(proposal.directions);
    if (!Kept([&](EventLog& log) { return log.AppendSamples(note.pose, record.end, *reduced); })) {
      return false;
    }
    const std::vector<BrdfSample> samples = SamplesOf(*reduced);

    parts_.planner.Observe(proposal, samples.front());
    for (std::size_t i = 1; i < samples.size(); ++i) parts_.planner.AlsoObserve(samples[i]);
    rejections_in_a_row_ = 0;
    summary_.frames += static_cast<int>(record.exposures.size());
    CountTime(record);
    summary_.poses.push_back({samples, record.end, parts_.planner.PredictedError()});
    last_ = SessionSoFar::Reference{.pose = note.pose,
                                    .arms = measurer_.state().told,
                                    .frames = proposal.frames,
                                    .before = samples.front()};
    return true;
  }

  // Exposures that are not what they are taken for. Without files nothing says what to expect.
  bool CheckBracket(const PoseRecord& record) {
    if (calibrations_.empty()) return true;
    const auto worst = LeastAgreement(record, parts_.rig, calibrations_);
    if (!worst) return EndWith(worst.error());
    if (!*worst || std::abs((*worst)->score()) < kMismatch) return true;
    return Kept([&](EventLog& log) {
      return log.AppendNote(record.end, "bracket_mismatch", TextOf(**worst));
    });
  }

  // A visit that is refused is tried again when the next is due, but the first one must succeed.
  bool VisitReference() {
    Draw(kVisitDraws + references_.visits());
    const auto visit = references_.Visit(measurer_, pose_count(), stop_.now);
    if (!visit && visit.error().code == ErrorCode::kRefused && references_.visits() > 0) {
      return Warn("reference_refused", "reference: " + visit.error().message);
    }
    if (!visit) return EndWith({visit.error().code, "reference: " + visit.error().message});
    if (!Kept([&](EventLog& log) { return log.AppendReference(*visit, measurer_.state()); }))
      return false;
    CountTime(visit->record);
    summary_.reference_visits = references_.visits();
    const std::string complaint = references_.Complaint(visit->record.end);
    if (complaint.empty()) return true;
    if (parts_.rig.drift.stop) return EndWith({ErrorCode::kRefused, complaint});
    return Warn("drift_exceeded", complaint);
  }

  bool Warn(const char* kind, const std::string& message) {
    summary_.warnings.push_back(message);
    return Kept([&](EventLog& log) { return log.AppendNote(parts_.clock.Now(), kind, message); });
  }

  void CountTime(const PoseRecord& record) {
    summary_.travel += record.move_time;
    summary_.exposing += ColourChangesOf(parts_.rig);
    for (const Exposure& exposure : record.exposures) {
      summary_.exposing += exposure.frame.exposure + parts_.rig.camera.readout;
    }
  }

  bool Reject(const Proposal& proposal, const Error& error) {
    if (!Kept([&](EventLog& log) {
          return log.AppendRejection(parts_.clock.Now(), {proposal, error, measurer_.state()});
        })) {
      return false;
    }
    parts_.planner.Reject(proposal);
    ++summary_.rejected;
    if (++rejections_in_a_row_ < options_.max_rejections_in_a_row) return true;
    return End(SessionOutcome::kDeviceFault,
               fmt::format("{} poses in a row were refused, the last because {}",
                           rejections_in_a_row_, error.message));
  }

  // Whether `write` succeeded, or there is no log; otherwise the session is over.
  template <typename Write>
  bool Kept(const Write& write) {
    if (parts_.log == nullptr) return true;
    const Result<void> written = write(*parts_.log);
    return written.ok() || End(SessionOutcome::kStorageFailed, written.error().message);
  }

  // These return false: the session is over.
  bool End(SessionOutcome outcome, std::string reason) {
    const bool failed =
        outcome == SessionOutcome::kDeviceFault || outcome == SessionOutcome::kStorageFailed;
    Enter(failed ? SessionSignal::kFail : SessionSignal::kStop);
    summary_.outcome = outcome;
    summary_.reason = std::move(reason);
    return false;
  }

  bool EndWith(const Error& error) {
    // Also where the device said kCancelled: it is at rest, the others may not be.
    (void)StopAll(parts_.devices).ok();
    if (error.code == ErrorCode::kCancelled) {
      return End(SessionOutcome::kStopped, "stopped by the user, the arms at once");
    }
    if (!Kept([&](EventLog& log) { return log.AppendError(parts_.clock.Now(), error); })) {
      return false;
    }
    return End(SessionOutcome::kDeviceFault, error.message);
  }

  void Finish() {
    CleanUp();
    Enter(SessionSignal::kCleanedUp);
  }

  void CleanUp() {
    (void)parts_.devices.light->SetLevel(0).ok();
    if (summary_.outcome == SessionOutcome::kStorageFailed ||
        summary_.outcome == SessionOutcome::kDeviceFault) {
      (void)StopAll(parts_.devices).ok();
    }
    summary_.duration = parts_.clock.Now() - begin_;
    summary_.gain = references_.At(parts_.clock.Now());
    summary_.predicted_error = parts_.planner.PredictedError();
    if (summary_.outcome == SessionOutcome::kStorageFailed) return;
    const SessionEnd end{.outcome = ToString(summary_.outcome),
                         .reason = summary_.reason,
                         .poses = pose_count(),
                         .rejected = summary_.rejected,
                         .duration = summary_.duration,
                         .predicted_error = summary_.predicted_error};
    Kept([&](EventLog& log) { return log.AppendEnd(parts_.clock.Now(), end); });
  }

  const SessionParts parts_;
  const SessionOptions options_;
  const SessionStop stop_;
  const ProgressFunction& progress_;
  const Calibrations& calibrations_;
  PoseMeasurer measurer_;
  ReferenceVisits references_;
  SessionState state_ = SessionState::kUnhomed;
  Seconds begin_{0};
  std::uint64_t turn_ = 0;
  int rejections_in_a_row_ = 0;
  std::optional<SessionSoFar::Reference> last_;  // the last measured pose
  SessionSummary summary_;
};

}  // namespace

SessionSummary RunSession(const SessionParts& parts, const SessionOptions& options,
                          const SessionStop& stop, const ProgressFunction& progress) {
  options.Check();
  return Session(parts, options, stop, progress).Run();
}

}  // namespace gonio
