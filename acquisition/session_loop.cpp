// SPDX-License-Identifier: Apache-2.0
// Turn by turn.

#include "acquisition/session_loop.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "acquisition/bracket_check.h"
#include "acquisition/light_colours.h"
#include "acquisition/radiometry.h"
#include "core/check.h"

namespace gonio {
namespace {

// However a session ends, exceptions included, the sample is not left in the light.
class LightOffAtEnd {
 public:
  explicit LightOffAtEnd(Devices& devices) : devices_(devices) {}
  ~LightOffAtEnd() {
    if (devices_.light) (void)devices_.light->SetLevel(0).ok();
  }
  LightOffAtEnd(const LightOffAtEnd&) = delete;
  LightOffAtEnd& operator=(const LightOffAtEnd&) = delete;

 private:
  Devices& devices_;
};

const Calibrations kNoCalibrations;

// Numbers of draws beyond those of any pose.
constexpr std::uint64_t kVisitDraws = std::uint64_t{2} << 32;

// Of the score of two exposures that do not agree: chance does this once in a million pairs.
constexpr double kMismatch = 5;

}  // namespace

SessionAbort::SessionAbort(const std::stop_token& user, Interlocks* interlocks)
    : interlocks_(interlocks), by_user_(user, [this] { source_.request_stop(); }) {
  if (interlocks_ != nullptr) interlocks_->SetOnTrip([this] { source_.request_stop(); });
}

SessionAbort::~SessionAbort() {
  if (interlocks_ != nullptr) interlocks_->SetOnTrip({});
}

SessionLoop::SessionLoop(const SessionParts& parts, const SessionOptions& options,
                         const SessionStop& stop, const ProgressFunction& progress)
    : parts_(parts),
      options_(options),
      stop_(stop),
      progress_(progress),
      calibrations_(parts.calibrations != nullptr ? *parts.calibrations : kNoCalibrations),
      measurer_(parts.rig, parts.devices, parts.clock,
                calibrations_.bad_pixels ? &calibrations_.bad_pixels->mask : nullptr),
      references_(parts.rig, calibrations_),
      failures_(parts.rig.failures,
                parts.so_far != nullptr ? parts.so_far->rejections_in_a_row : 0) {
  if (parts.so_far == nullptr) return;
  summary_ = parts.so_far->summary;
  turn_ = parts.so_far->turns;
  for (const LoggedVisit& visit : parts.so_far->visits) references_.Recall(visit);
  if (parts.so_far->first) references_.Offer(*parts.so_far->first);
  summary_.reference_visits = references_.visits();
  last_ = parts.so_far->reference;
}

SessionSummary SessionLoop::Run() {
  const LightOffAtEnd light_off(parts_.devices);
  if (parts_.so_far == nullptr) begin_ = parts_.clock.Now();
  if (WaitForSurroundings() && Prepare() && GoBack()) {
    while (Step()) {
      if (state_ == SessionState::kRunning) Enter(SessionSignal::kPoseDone);
      if (progress_) progress_(CurrentProgress());
    }
  }
  Finish();
  return std::move(summary_);
}

void SessionLoop::Enter(SessionSignal signal) {
  const std::optional<SessionState> next = After(state_, signal);
  GONIO_CHECK(next.has_value(), fmt::format("signal {} means nothing to a session that is {}",
                                            static_cast<int>(signal), ToString(state_)));
  state_ = *next;
  if (parts_.on_state) parts_.on_state(state_);
}

Progress SessionLoop::CurrentProgress() const {
  return {.poses = pose_count(),
          .max_poses = parts_.planner.MaxPoses(),
          .rejected = summary_.rejected,
          .elapsed = parts_.clock.Now() - begin_,
          .predicted_error = parts_.planner.PredictedError()};
}

bool SessionLoop::Note(const char* kind, const std::string& message) {
  if (parts_.on_event) parts_.on_event({kind, message});
  return Kept([&](EventLog& log) { return log.AppendNote(parts_.clock.Now(), kind, message); });
}

bool SessionLoop::Warn(const char* kind, const std::string& message) {
  summary_.warnings.push_back(message);
  return Note(kind, message);
}

void SessionLoop::Draw(std::uint64_t number) {
  if (parts_.draw) parts_.draw(number);
}

bool SessionLoop::Prepare() {
  const Seconds before = parts_.clock.Now();
  Result<void> prepared;
  {
    const SessionAbort abort(stop_.now, parts_.interlocks);
    prepared = measurer_.Prepare(abort.token());
  }
  summary_.preparation += parts_.clock.Now() - before;
  if (!prepared.ok()) return EndWith(prepared.error());
  Enter(SessionSignal::kHomed);
  if (!Kept([&](EventLog& log) {
        return log.AppendNote(parts_.clock.Now(), "prepared", "every axis homed, light on");
      })) {
    return false;
  }
  Enter(SessionSignal::kStart);
  return true;
}

bool SessionLoop::StillWanted() {
  if (stop_.now.stop_requested()) {
    return EndWith({ErrorCode::kCancelled, "stopped between poses"});
  }
  if (stop_.after_pose.stop_requested()) {
    return End(SessionOutcome::kStopped, "stopped by the user");
  }
  return true;
}

// One turn of the loop.
bool SessionLoop::Step() {
  if (!StillWanted()) return false;
  if (stop_.pause && stop_.pause() && !(Pause() && StillWanted())) return false;
  if (const auto trip = CheckInterlocks()) return Suspend(*trip, measurer_.state());
  if (references_.Due(pose_count(), parts_.clock.Now())) {
    if (!VisitReference()) return false;
    if (state_ != SessionState::kRunning) return true;
  }
  const std::optional<Proposal> proposal = parts_.planner.Next();
  if (!proposal) return End(SessionOutcome::kComplete, parts_.planner.reason());

  Draw(turn_ + 1);
  const MeasurerState before = measurer_.state();
  const std::optional<Rgb> expected = parts_.planner.Predict(proposal->directions);
  const Result<PoseRecord> record = [&] {
    const SessionAbort abort(stop_.now, parts_.interlocks);
    return measurer_.Measure(proposal->directions, expected, abort.token(), proposal->frames);
  }();
  const auto trip = CheckInterlocks();
  if (trip && Concerns(*trip, record)) return Discard(*proposal, *trip, before);
  if (record.ok()) return Take(*proposal, *record);
  return Fail(record.error(), before, &*proposal);
}

// Keeps a measured pose, reduces it and tells the planner, in this order.
bool SessionLoop::Take(const Proposal& proposal, const PoseRecord& record) {
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
  failures_.Measured();
  ++turn_;
  summary_.frames += static_cast<int>(record.exposures.size());
  CountTime(record);
  summary_.poses.push_back({samples, record.end, parts_.planner.PredictedError()});
  last_ = SessionSoFar::Reference{.pose = note.pose,
                                  .arms = measurer_.state().told,
                                  .frames = proposal.frames,
                                  .before = samples.front()};
  return true;
}

bool SessionLoop::Reject(const Proposal& proposal, const Error& error) {
  if (!Kept([&](EventLog& log) {
        return log.AppendRejection(parts_.clock.Now(), {proposal, error, measurer_.state()});
      })) {
    return false;
  }
  parts_.planner.Reject(proposal);
  ++summary_.rejected;
  ++turn_;
  failures_.Closed();
  if (!failures_.TooMany()) return true;
  return End(SessionOutcome::kDeviceFault,
             fmt::format("{} failures with no pose measured between, the last: {}",
                         failures_.in_a_row(), error.message));
}

// Exposures that are not what they are taken for. Without files nothing says what to expect.
bool SessionLoop::CheckBracket(const PoseRecord& record) {
  if (calibrations_.empty()) return true;
  const auto worst = LeastAgreement(record, parts_.rig, calibrations_);
  if (!worst) return EndWith(worst.error());
  if (!*worst || std::abs((*worst)->score()) < kMismatch) return true;
  return Kept([&](EventLog& log) {
    return log.AppendNote(record.end, "bracket_mismatch", TextOf(**worst));
  });
}

// A visit that is refused is tried again when the next is due, but the first one must succeed.
bool SessionLoop::VisitReference() {
  Draw(kVisitDraws + references_.visits());
  const MeasurerState before = measurer_.state();
  const auto visit = [&] {
    const SessionAbort abort(stop_.now, parts_.interlocks);
    return references_.Visit(measurer_, pose_count(), abort.token());
  }();
  const auto trip = CheckInterlocks();
  if (trip && Concerns(*trip, visit)) return Suspend(*trip, before);
  if (!visit) {
    const Error error{visit.error().code, "reference: " + visit.error().message};
    if (error.code != ErrorCode::kRefused) return Fail(error, before, nullptr);
    return references_.visits() == 0 ? EndWith(error) : Warn("reference_refused", error.message);
  }
  if (!Kept([&](EventLog& log) { return log.AppendReference(*visit, measurer_.state()); })) {
    return false;
  }
  CountTime(visit->record);
  summary_.reference_visits = references_.visits();
  const std::string complaint = references_.Complaint(visit->record.end);
  if (complaint.empty()) return true;
  if (parts_.rig.drift.stop) return EndWith({ErrorCode::kRefused, complaint});
  return Warn("drift_exceeded", complaint);
}

void SessionLoop::CountTime(const PoseRecord& record) {
  summary_.travel += record.move_time;
  summary_.exposing += ColourChangesOf(parts_.rig);
  for (const Exposure& exposure : record.exposures) {
    summary_.exposing += exposure.frame.exposure + parts_.rig.camera.readout;
  }
}

}  // namespace gonio
