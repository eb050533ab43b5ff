// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "acquisition/bracket_check.h"
#include "acquisition/measure.h"
#include "acquisition/radiometry.h"
#include "acquisition/reference_visits.h"
#include "core/check.h"

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
        references_(parts.rig, calibrations_) {}

  SessionSummary Run() {
    const LightOffAtEnd light_off(*parts_.devices.light);
    begin_ = parts_.clock.Now();
    if (Prepare()) {
      while (Step()) {
        if (progress_) progress_(CurrentProgress());
      }
    }
    Finish();
    return std::move(summary_);
  }

 private:
  int pose_count() const { return static_cast<int>(summary_.poses.size()); }

  Progress CurrentProgress() const {
    return {.poses = pose_count(),
            .max_poses = parts_.planner.MaxPoses(),
            .rejected = summary_.rejected,
            .elapsed = parts_.clock.Now() - begin_,
            .predicted_error = parts_.planner.PredictedError()};
  }

  bool Prepare() {
    const Result<void> prepared = measurer_.Prepare(stop_.now);
    summary_.preparation = parts_.clock.Now() - begin_;
    if (!prepared.ok()) return EndWith(prepared.error());
    return Kept([&](EventLog& log) {
      return log.AppendNote(parts_.clock.Now(), "prepared", "every axis homed, light on");
    });
  }

  // One turn of the loop; false once the session is over.
  bool Step() {
    if (stop_.after_pose.stop_requested()) {
      return End(SessionOutcome::kStopped, "stopped by the user");
    }
    if (references_.Due(pose_count(), parts_.clock.Now()) && !VisitReference()) return false;
    const std::optional<Proposal> proposal = parts_.planner.Next();
    if (!proposal) return End(SessionOutcome::kComplete, parts_.planner.reason());

    const std::optional<Rgb> expected = parts_.planner.Predict(proposal->directions);
    Result<PoseRecord> record =
        measurer_.Measure(proposal->directions, expected, stop_.now, proposal->frames);
    if (record.ok()) return Take(*proposal, *record);
    if (record.error().code == ErrorCode::kRefused) return Reject(*proposal, record.error());
    return EndWith(record.error());
  }

  // Keeps a measured pose, reduces it and tells the planner, in this order.
  bool Take(const Proposal& proposal, const PoseRecord& record) {
    const PoseNote note{pose_count() + 1, proposal, parts_.planner.PredictedError()};
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
    const auto visit = references_.Visit(measurer_, pose_count(), stop_.now);
    if (!visit && visit.error().code == ErrorCode::kRefused && references_.visits() > 0) {
      return Warn("reference_refused", "reference: " + visit.error().message);
    }
    if (!visit) return EndWith({visit.error().code, "reference: " + visit.error().message});
    if (!Kept([&](EventLog& log) { return log.AppendReference(*visit); })) return false;
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
    for (const Exposure& exposure : record.exposures) {
      summary_.exposing += exposure.frame.exposure + parts_.rig.camera.readout;
    }
  }

  bool Reject(const Proposal& proposal, const Error& error) {
    if (!Kept([&](EventLog& log) {
          return log.AppendRejection(parts_.clock.Now(), proposal, error);
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
  Seconds begin_{0};
  int rejections_in_a_row_ = 0;
  SessionSummary summary_;
};

}  // namespace

void SessionOptions::Check() const {
  if (max_rejections_in_a_row < 1) {
    throw ConfigError(
        fmt::format("max_rejections_in_a_row: is {}, must be >= 1", max_rejections_in_a_row));
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

SessionSummary RunSession(const SessionParts& parts, const SessionOptions& options,
                          const SessionStop& stop, const ProgressFunction& progress) {
  options.Check();
  return Session(parts, options, stop, progress).Run();
}

}  // namespace gonio
