// SPDX-License-Identifier: Apache-2.0
#include "drivers/grbl_machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "drivers/grbl_legs.h"
#include "drivers/wire_text.h"

namespace gonio::grbl {
namespace {

constexpr Seconds kGlance{0.01};     // at the line while it homes and nothing may be asked
constexpr Seconds kBrakePoll{0.05};  // it has other things to do than to report
constexpr Seconds kBrakeLimit{5};
constexpr double kReportDigit = 1e-3;  // deg
constexpr double kRounding = 1e-3;     // share by which a setting may come back different
constexpr int kStepsPerUnit = 100;     // setting of the first axis

std::size_t Index(int axis) { return static_cast<std::size_t>(axis); }

bool IsAtRest(const Report& report) {
  return report.state == State::kIdle || report.state == State::kAlarm;
}

// Takes no line until it was reset.
bool IsStuck(const Report& report) {
  return report.state == State::kSleep || report.state == State::kCheck ||
         (report.state == State::kHold && report.detail == 0) ||
         (report.state == State::kDoor && report.detail < 2);
}

// "VER:1.1h.20190825:left arm" without "VER:"
std::string After(const std::string& text, std::string_view prefix) {
  return text.compare(0, prefix.size(), prefix) == 0 ? text.substr(prefix.size()) : std::string();
}

}  // namespace

Machine::Machine(std::unique_ptr<ByteLink> link, Clock* clock, const Times& times)
    : line_(std::move(link), times.reply), clock_(clock) {}

Result<std::shared_ptr<Machine>> Machine::Open(std::unique_ptr<ByteLink> link, Clock* clock,
                                               const Times& times) {
  std::shared_ptr<Machine> machine(new Machine(std::move(link), clock, times));
  if (const auto known = machine->Identify(times.boot); !known) return known.error();
  return machine;
}

Error Machine::Refused(const std::string& why) const {
  return {ErrorCode::kRefused, fmt::format("{}: {}", line_.name(), why)};
}

Result<void> Machine::Identify(Seconds boot) {
  const Result<void> welcome = line_.AwaitWelcome(boot);
  if (!welcome && welcome.error().code != ErrorCode::kTimeout) return welcome;
  const Result<Report> report = Ask();
  if (!report) return report.error();
  if (line_.condition().blocked()) {
    return Refused(fmt::format("is blocked since {}: reset it", line_.condition().fault()));
  }
  if (!IsAtRest(*report)) {
    return Refused(fmt::format("is {}: end that, or reset it", TextOf(report->state)));
  }
  axes_ = static_cast<int>(std::min(report->position.size(), Index(kMostAxes)));
  const Result<std::vector<Message>> info = line_.Tell("$I");
  if (!info) return info.error();
  std::string version;
  for (const Message& message : *info) {
    if (version.empty()) version = After(message.text, "VER:");
    if (options_.empty()) options_ = After(message.text, "OPT:");
  }
  if (!version.empty() && version.front() == 'v') version.erase(0, 1);
  if (version.compare(0, 3, "1.1") != 0) {
    return Refused(fmt::format("version {} is not Grbl 1.1", Quoted(version)));
  }
  const std::size_t colon = std::min(version.find(':'), version.size());
  const std::string owner = version.substr(std::min(colon + 1, version.size()));
  identity_ = fmt::format("Grbl {}{}, options {}", version.substr(0, colon),
                          owner.empty() ? "" : ", " + Quoted(owner), Quoted(options_));
  return ReadSettings();
}

Result<void> Machine::ReadSettings() {
  const Result<std::vector<Message>> said = line_.Tell("$$");
  if (!said) return said.error();
  settings_.clear();
  for (const Message& message : *said) {
    if (message.kind == Kind::kSetting) settings_[message.code] = message.text;
  }
  return {};
}

Result<double> Machine::Get(int number) const {
  const auto setting = settings_.find(number);
  if (setting == settings_.end()) return Refused(fmt::format("has no setting ${}", number));
  return NumberIn(setting->second, fmt::format("{}: ${}", line_.name(), number));
}

Result<double> Machine::Setting(int number) {
  const std::lock_guard lock(mutex_);
  return Get(number);
}

Result<void> Machine::Set(int number, double value) {
  const std::lock_guard lock(mutex_);
  const auto is_set = [&](const Result<double>& got) {
    return got && std::abs(*got - value) <= kRounding * value;
  };
  if (is_set(Get(number))) return {};
  const auto set = line_.Tell(fmt::format("${}={:.3f}", number, value));
  if (!set) return set.error();
  if (const Result<void> read = ReadSettings(); !read) return read;
  const Result<double> got = Get(number);
  if (!got) return got.error();
  if (is_set(got)) return {};
  return Refused(fmt::format("${} was set to {:.6g} and reads {:.6g}", number, value, *got));
}

Result<double> Machine::Resolution(int axis) {
  const std::lock_guard lock(mutex_);
  const Result<double> steps = Get(kStepsPerUnit + axis);
  if (!steps) return steps;
  if (!(*steps > 0)) return Refused(fmt::format("${} is {}", kStepsPerUnit + axis, *steps));
  return 0.5 / *steps + kReportDigit;
}

// With a position for each axis.
Result<Report> Machine::Ask() {
  Result<Report> report = line_.AskStatus();
  if (!report || report->position.size() >= Index(axes_)) return report;
  return Error{ErrorCode::kProtocol, fmt::format("{}: reports {} axes instead of {}", line_.name(),
                                                 report->position.size(), axes_)};
}

bool Machine::IsThere(int axis, const Report& report) const {
  const std::optional<Goal>& goal = goals_[Index(axis)];
  const Result<double> steps = Get(kStepsPerUnit + axis);
  const double resolution = steps && *steps > 0 ? 0.5 / *steps + kReportDigit : kReportDigit;
  return goal && std::abs(report.position[Index(axis)] - goal->target) <= resolution;
}

// Jogs that are not ours, and those that were told to stop, move nobody knows whom.
bool Machine::IsMoving(int axis, const Report& report) const {
  switch (report.state) {
    case State::kJog: {
      const bool ours = std::any_of(goals_.begin(), goals_.end(),
                                    [](const auto& goal) { return goal.has_value(); });
      return !ours || (goals_[Index(axis)] && !IsThere(axis, report));
    }
    case State::kRun:
    case State::kHome:
      return true;
    case State::kHold:
    case State::kDoor:
      return !IsStuck(report);
    default:
      return false;
  }
}

Result<ControllerStatus> Machine::Status(int axis) {
  const std::lock_guard lock(mutex_);
  if (line_.condition().homing()) {
    if (const Result<void> heard = line_.Hear(kGlance); !heard) return heard.error();
  }
  const Result<Report> report = Ask();
  if (!report) return report.error();
  const Condition& condition = line_.condition();
  if (IsAtRest(*report) || condition.blocked()) goals_.fill(std::nullopt);
  ControllerStatus status{
      .position = report->position[Index(axis)],
      .homed = condition.homed(),
      .moving = condition.homing() || (!condition.blocked() && IsMoving(axis, *report)),
      .enabled = report->state != State::kSleep,
      .fault = condition.fault()};
  if (status.fault.empty() && status.enabled && IsStuck(*report)) {
    status.fault = "it is " + TextOf(report->state);
  }
  return status;
}

Result<void> Machine::StartHoming(int axis) {
  const std::lock_guard lock(mutex_);
  unsigned& relies_on = relies_on_[Index(axis)];
  for (bool was_reset = false;; was_reset = true) {
    const Result<Report> report = Ask();
    if (!report) return report.error();
    const Condition& condition = line_.condition();
    if (condition.homed() && condition.homings() != relies_on && report->state == State::kIdle) {
      relies_on = condition.homings();
      return {};
    }
    if (!condition.homing() && (condition.blocked() || IsStuck(*report)) && !was_reset) {
      if (const Result<void> reset = line_.Reset(); !reset) return reset;
      continue;
    }
    if (!condition.homing() && !IsAtRest(*report)) {
      return Refused(fmt::format("cannot home while it is {}", TextOf(report->state)));
    }
    relies_on = condition.homings() + 1;
    return condition.homing() ? Result<void>() : line_.StartHoming();
  }
}

// At rest, with the goals of those that were on their way.
Result<Report> Machine::Brake(unsigned stops) {
  Result<Report> report = Ask();
  if (!report) return report;
  if (const Result<void> may = MayMove(); !may) return may.error();
  if (report->state == State::kJog) {
    for (int axis = 0; axis < axes_; ++axis) {
      if (IsThere(axis, *report)) goals_[Index(axis)].reset();
    }
    report = AwaitIdle(stops);
    // Nobody sends them on again.
    if (!report) goals_.fill(std::nullopt);
    return report;
  }
  goals_.fill(std::nullopt);
  return MustBeIdle(*report);
}

Result<void> Machine::MayMove() const {
  const Condition& condition = line_.condition();
  if (condition.blocked()) return Refused("is blocked since " + condition.fault());
  return condition.homed() ? Result<void>() : Refused("is not homed");
}

Result<Report> Machine::MustBeIdle(const Report& report) const {
  if (report.state == State::kIdle) return report;
  return Refused(fmt::format("cannot move while it is {}", TextOf(report.state)));
}

Result<Report> Machine::AwaitIdle(unsigned stops) {
  const Seconds begin = clock_->Now();
  if (const Result<void> sent = line_.Send(kCancelJog); !sent) return sent.error();
  while (clock_->Now() - begin < kBrakeLimit) {
    if (stops_ != stops) {
      return Error{ErrorCode::kCancelled, line_.name() + ": told to stop before it began to move"};
    }
    const Result<Report> report = Ask();
    if (!report) return report;
    if (const Result<void> may = MayMove(); !may) return may.error();
    if (report->state != State::kJog) return MustBeIdle(*report);
    clock_->SleepFor(kBrakePoll);
  }
  return Error{ErrorCode::kTimeout,
               fmt::format("{}: still brakes after {:.3g} s", line_.name(), kBrakeLimit.count())};
}

Result<void> Machine::SendLegs(const Report& report) {
  std::vector<Way> ways;
  for (int axis = 0; axis < axes_; ++axis) {
    const std::optional<Goal>& goal = goals_[Index(axis)];
    if (!goal) continue;
    ways.push_back({.axis = axis,
                    .from = report.position[Index(axis)],
                    .to = goal->target,
                    .speed = goal->speed});
  }
  for (const Leg& leg : LegsOf(ways)) {
    if (const auto told = line_.Tell(Encode(leg)); !told) return told.error();
  }
  return {};
}

Result<void> Machine::StartMove(int axis, double target, double speed) {
  const unsigned stops = stops_;  // before the lock is waited for
  const std::lock_guard lock(mutex_);
  const Result<Report> report = Brake(stops);
  if (!report) return report.error();
  goals_[Index(axis)] = Goal{target, speed};
  relies_on_[Index(axis)] = line_.condition().homings();
  Result<void> sent = SendLegs(*report);
  if (!sent) {
    goals_.fill(std::nullopt);
    (void)line_.Send(kCancelJog);
  }
  return sent;
}

Result<void> Machine::Stop() {
  ++stops_;
  const std::lock_guard lock(mutex_);
  goals_.fill(std::nullopt);
  if (line_.condition().homing()) return line_.Reset();
  return line_.Send(kCancelJog);
}

Result<void> Machine::EmergencyStop() {
  ++stops_;
  const std::lock_guard lock(mutex_);
  goals_.fill(std::nullopt);
  if (const Result<void> sent = line_.Send(kFeedHold); !sent) return sent;
  return line_.Reset();
}

Result<void> Machine::Reset() {
  const std::lock_guard lock(mutex_);
  goals_.fill(std::nullopt);
  return line_.Reset();
}

}  // namespace gonio::grbl
