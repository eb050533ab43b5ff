// SPDX-License-Identifier: Apache-2.0
#include "drivers/esp301_axis.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/units.h"
#include "drivers/asked_twice.h"
#include "drivers/awaited_line.h"
#include "drivers/wire_text.h"

namespace gonio::esp301 {
namespace {

constexpr double kRounding = 1e-3;     // share by which a setting may come back different
constexpr int kMostQueuedErrors = 32;  // it keeps ten; one that never ends is not read for ever

class Controller final : public MotionController {
 public:
  Controller(std::shared_ptr<Line> line, const AxisAddress& address,
             const ControllerAxisSettings& settings)
      : line_(std::move(line)),
        address_(address),
        settings_(settings),
        speed_(DegFromRad(settings.limits.max_speed)) {}

  std::string Identity() const override { return identity_; }
  Result<ControllerStatus> Status() override;
  Result<void> Enable() override { return line_->Command(address_.axis, "MO"); }
  Result<void> StartHoming() override;
  Result<void> StartMove(double position) override {
    return line_->Command(address_.axis, fmt::format("PA{:.6f}", position));
  }
  Result<void> StartStop() override;
  Result<void> StartEmergencyStop() override;

  // Who it is, its unit, limits and speeds: what has to be right before anything moves.
  Result<void> Prepare();

 private:
  enum class Reference { kNone, kSought, kBeingSought, kFound };

  Result<void> Identify();
  Result<void> CheckUnit();
  Result<void> SetSpeeds();
  Result<void> Set(const std::string& setting, double value);
  // What the answers to one round of questions say of the reference.
  Reference Judge(bool done, bool enabled, bool set_up, bool fault);
  void GiveUpHoming();

  const std::shared_ptr<Line> line_;
  const AxisAddress address_;
  const ControllerAxisSettings settings_;
  const double speed_;  // deg/s
  std::string identity_;
  std::mutex mutex_;  // of what follows: stops come from any thread
  Reference reference_ = Reference::kNone;
  int stops_ = 0;
  int faults_forgiven_ = 0;
};

Result<ControllerStatus> Controller::Status() {
  const int axis = address_.axis;
  // Whether it moves comes first: then the position of one that does not is its last.
  const Result<bool> done = line_->Flag(axis, "MD?");
  if (!done) return done.error();
  const Result<double> position = line_->Value(axis, "TP?");
  if (!position) return position.error();
  const Result<bool> enabled = line_->Flag(axis, "MO?");
  if (!enabled) return enabled.error();
  const Result<double> speed = line_->Value(axis, "VA?");
  if (!speed) return speed.error();
  if (const auto read = line_->ReadErrors(); !read) return read.error();

  const std::lock_guard lock(mutex_);
  std::string fault = line_->FaultAfter(faults_forgiven_, axis);
  const bool emergency = fault == kEmergencyStop;
  const bool set_up = std::abs(*speed - speed_) <= kRounding * speed_;
  reference_ = Judge(*done, *enabled, set_up, !fault.empty());
  const bool sought = reference_ == Reference::kSought || reference_ == Reference::kBeingSought;
  return ControllerStatus{.position = *position,
                          .homed = reference_ == Reference::kFound,
                          .moving = !*done || sought,
                          .enabled = *enabled,
                          .fault = std::move(fault),
                          .emergency = emergency};
}

// Homing counts only once it was seen to move: else "done" may be from before it began.
Controller::Reference Controller::Judge(bool done, bool enabled, bool set_up, bool fault) {
  if (!enabled || !set_up || fault) return Reference::kNone;
  if (reference_ == Reference::kSought && !done) return Reference::kBeingSought;
  if (reference_ == Reference::kBeingSought && done) return Reference::kFound;
  return reference_;
}

Result<void> Controller::StartHoming() {
  if (const auto unit = CheckUnit(); !unit) return unit;
  if (const auto set = SetSpeeds(); !set) return set;
  int stops = 0;
  {
    const std::lock_guard lock(mutex_);
    reference_ = Reference::kNone;
    faults_forgiven_ = line_->faults();
    stops = stops_;
  }
  const auto told = line_->Command(address_.axis, fmt::format("OR{}", address_.home_mode));
  if (!told) return told;
  const std::lock_guard lock(mutex_);
  if (stops_ == stops) reference_ = Reference::kSought;
  return {};
}

// Before a stop is sent: the end it puts to the search must not be taken for the good one.
void Controller::GiveUpHoming() {
  const std::lock_guard lock(mutex_);
  ++stops_;
  if (reference_ != Reference::kFound) reference_ = Reference::kNone;
}

Result<void> Controller::StartStop() {
  GiveUpHoming();
  return line_->StopCommand(address_.axis, "ST");
}

Result<void> Controller::StartEmergencyStop() {
  GiveUpHoming();
  return line_->AbortCommand();
}

Result<void> Controller::Identify() {
  const Result<std::string> version = line_->Version();
  if (!version) return version.error();
  const Result<std::string> stage = line_->Text(address_.axis, "ID?");
  if (!stage) return stage.error();
  identity_ = fmt::format("Newport {}, axis {}: {}", *version, address_.axis, *stage);
  return {};
}

Result<void> Controller::CheckUnit() {
  const Result<int> unit = line_->Unit(address_.axis);
  if (!unit) return unit.error();
  if (*unit != kDegrees) {
    return Error{ErrorCode::kRefused,
                 fmt::format("axis {} counts in {} (SN {}), not in degrees (SN {})", address_.axis,
                             TextOfUnit(*unit), *unit, kDegrees)};
  }
  return {};
}

Result<void> Controller::SetSpeeds() {
  const double acceleration = DegFromRad(settings_.limits.acceleration);
  if (const auto set = Set("VA", speed_); !set) return set;
  if (const auto set = Set("AC", acceleration); !set) return set;
  return Set("AG", acceleration);
}

Result<void> Controller::Set(const std::string& setting, double value) {
  const auto set = line_->Command(address_.axis, fmt::format("{}{:.6f}", setting, value));
  if (!set) return set;
  const Result<double> got = line_->Value(address_.axis, setting + "?");
  if (!got) return got.error();
  return ReadBackAs(setting, value, *got, kRounding * value);
}

Result<void> Controller::Prepare() {
  if (address_.home_mode < 1 || address_.home_mode > 6) {
    return Error{ErrorCode::kRefused,
                 fmt::format("home mode is {}, must be 1 to 6: no other looks for a mark",
                             address_.home_mode)};
  }
  if (const auto known = Identify(); !known) return known;
  if (const auto unit = CheckUnit(); !unit) return unit;
  const Result<double> least = line_->Value(address_.axis, "SL?");
  if (!least) return least.error();
  const Result<double> most = line_->Value(address_.axis, "SR?");
  if (!most) return most.error();
  const std::string outside = OutsideOf(settings_.limits, settings_.scale, *least, *most);
  if (!outside.empty()) return Error{ErrorCode::kRefused, outside + " (SL, SR)"};
  return SetSpeeds();
}

}  // namespace

Line::Line(std::unique_ptr<ByteLink> link, Seconds reply_limit)
    : link_(std::move(link)), lines_(link_.get()), reply_limit_(reply_limit) {}

Result<std::string> Line::Version() {
  auto version = Ask(0, "VE?", [](std::string_view line) -> Result<std::string> {
    if (IsVersion(line)) return std::string(line);
    return Error{ErrorCode::kProtocol, Quoted(line) + " is no ESP301 or ESP300"};
  });
  // Twice the same nonsense is another device.
  if (!version && version.error().code == ErrorCode::kProtocol) {
    return Error{ErrorCode::kRefused, version.error().message};
  }
  return version;
}

Result<std::string> Line::Text(int axis, const std::string& question) {
  return Ask(axis, question,
             [](std::string_view line) { return Result<std::string>(std::string(line)); });
}

Result<double> Line::Value(int axis, const std::string& question) {
  return Ask(axis, question, [&](std::string_view line) { return ValueIn(line, question); });
}

Result<bool> Line::Flag(int axis, const std::string& question) {
  return Ask(axis, question, [&](std::string_view line) { return FlagIn(line, question); });
}

Result<int> Line::Unit(int axis) { return Ask(axis, "SN?", UnitIn); }

template <typename Decode>
auto Line::Ask(int axis, const std::string& question, Decode decode)
    -> decltype(decode(std::string_view())) {
  using Answer = decltype(decode(std::string_view()));
  const std::lock_guard lock(mutex_);
  Answer answer = AskedTwice([&]() -> Answer {
    const Result<std::string> line = Exchange(axis, question);
    if (!line) return line.error();
    Answer decoded = decode(*line);
    if (decoded) return decoded;
    in_step_ = false;
    return About(axis, question, decoded.error());
  });
  if (answer || answer.error().code != ErrorCode::kTimeout) return answer;
  // A question that it does not like is passed over, too.
  const Result<QueuedError> why = EmptyQueue(axis);
  return why && !why->none() ? Answer(Refused(axis, question, *why)) : answer;
}

Result<void> Line::Command(int axis, const std::string& command) {
  const std::lock_guard lock(mutex_);
  if (const auto before = EmptyQueue(axis); !before) return before.error();
  aborted_ = false;
  const auto sent = link_->Write(Encode(axis, command), reply_limit_);
  if (!sent) return sent.error();
  const Result<QueuedError> error = EmptyQueue(axis);
  if (!error) return error.error();
  return error->none() ? Result<void>() : Refused(axis, command, *error);
}

Result<void> Line::StopCommand(int axis, const std::string& command) {
  const std::lock_guard lock(mutex_);
  const auto sent = link_->Write(Encode(axis, command), reply_limit_);
  if (!sent) return sent.error();
  const Result<QueuedError> error = EmptyQueue(axis);
  return error ? Result<void>() : error.error();
}

Result<void> Line::AbortCommand() {
  {
    const std::lock_guard lock(mutex_);
    aborted_ = true;
  }
  return StopCommand(0, "AB");
}

Result<void> Line::ReadErrors() {
  const std::lock_guard lock(mutex_);
  const Result<QueuedError> error = EmptyQueue(0);
  return error ? Result<void>() : error.error();
}

// An error is gone once it has been sent, so this question is not asked again.
Result<QueuedError> Line::EmptyQueue(int axis) {
  QueuedError first;
  for (int read = 0; read < kMostQueuedErrors; ++read) {
    const Result<std::string> line = Exchange(0, "TE?");
    if (!line) return line.error();
    const Result<QueuedError> error = ErrorIn(*line);
    if (!error) {
      in_step_ = false;
      return About(0, "TE?", error.error());
    }
    if (error->none()) return first;
    if (IsFault(*error)) {
      const std::string text = TextOf(*error);
      faults_.Note(error->axis, aborted_ && text == kEmergencyStop ? "aborted" : text);
    }
    const bool ours = error->axis == axis || error->axis == 0;
    if (ours && first.none()) first = *error;
  }
  return Error{ErrorCode::kProtocol,
               fmt::format("{}: over {} errors in its queue", link_->name(), kMostQueuedErrors)};
}

int Line::faults() const {
  const std::lock_guard lock(mutex_);
  return faults_.pages();
}

std::string Line::FaultAfter(int faults, int axis) const {
  const std::lock_guard lock(mutex_);
  return faults_.After(faults, axis);
}

Result<std::string> Line::Exchange(int axis, const std::string& question) {
  if (!in_step_) {
    if (const auto stepped = GetInStep(); !stepped) return About(axis, question, stepped.error());
  }
  if (const auto discarded = lines_.Discard(); !discarded) return discarded.error();
  const auto sent = link_->Write(Encode(axis, question), reply_limit_);
  if (!sent) return sent.error();
  const auto line =
      AwaitedLine(lines_, reply_limit_, [](std::string_view heard) { return !IsUnasked(heard); });
  if (line) return line;
  in_step_ = false;
  return About(axis, question, line.error());
}

Result<void> Line::GetInStep() {
  if (const auto discarded = lines_.Discard(); !discarded) return discarded.error();
  const auto sent = link_->Write(Encode(0, "VE?"), reply_limit_);
  if (!sent) return sent.error();
  const auto version = AwaitedLine(lines_, reply_limit_, IsVersion);
  if (!version) return version.error();
  in_step_ = true;
  return {};
}

Error Line::Refused(int axis, const std::string& what, const QueuedError& why) const {
  return {ErrorCode::kRefused,
          fmt::format("{}: axis {} refused {}: {}", link_->name(), axis, what, TextOf(why))};
}

Error Line::About(int axis, const std::string& question, const Error& error) const {
  if (error.code == ErrorCode::kDisconnected) return error;
  const bool named = error.message.compare(0, link_->name().size(), link_->name()) == 0;
  return {error.code,
          fmt::format("{}{}, asked {}", named ? "" : link_->name() + ": ", error.message,
                      axis == 0 ? question : fmt::format("{}{}", axis, question))};
}

Result<std::unique_ptr<Axis>> OpenAxis(std::shared_ptr<Line> line, const AxisAddress& address,
                                       const ControllerAxisSettings& settings, Clock* clock) {
  ControllerAxisSettings prepared = settings;
  prepared.scale.units_per_radian = DegFromRad(1);
  auto controller = std::make_unique<Controller>(std::move(line), address, prepared);
  const auto done = controller->Prepare();
  return OpenedAxis(std::move(controller), done, prepared, clock);
}

}  // namespace gonio::esp301
