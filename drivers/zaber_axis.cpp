// SPDX-License-Identifier: Apache-2.0
#include "drivers/zaber_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/units.h"

namespace gonio::zaber {
namespace {

constexpr Seconds kPoll{0.05};                   // while it moves
constexpr Seconds kStopLimit{5};                 // braking takes longer only if something is wrong
constexpr double kSpeedUnit = 1.6384;            // of the data of speeds, per microstep / s
constexpr double kAccelerationUnit = 1.6384e-4;  // per microstep / s^2
constexpr double kRounding = 0.01;               // share by which a setting may come back different

bool LostReference(const std::string& warning) { return warning == "WR" || warning == "WH"; }

// Flags that end a move short of its target. Those it stops itself for, and a stop we asked for
// (NI), are no faults.
bool IsFault(const std::string& warning) {
  return !warning.empty() && (warning.front() == 'F' || warning == "WL");
}

}  // namespace

Result<std::unique_ptr<ZaberAxis>> ZaberAxis::Open(std::shared_ptr<Chain> chain,
                                                   const AxisSettings& settings, Clock* clock) {
  std::unique_ptr<ZaberAxis> axis(new ZaberAxis(std::move(chain), settings, clock));
  if (const auto read = axis->ReadScaleAndLimits(); !read) return read.error();
  if (const auto set = axis->SetSpeed(); !set) return set.error();
  return axis;
}

ZaberAxis::ZaberAxis(std::shared_ptr<Chain> chain, const AxisSettings& settings, Clock* clock)
    : chain_(std::move(chain)), settings_(settings), clock_(clock) {}

ZaberAxis::~ZaberAxis() {
  // Nobody is left to hear how it went.
  if (steps_per_radian_ > 0) (void)Stop();
}

Result<void> ZaberAxis::ReadScaleAndLimits() {
  const Result<double> turn = Setting("limit.cycle.dist");
  if (!turn) return turn.error();
  if (!(*turn > 0)) {
    return Fail(ErrorCode::kRefused, "not a rotary stage: limit.cycle.dist is 0");
  }
  const Result<double> least = Setting("limit.min");
  if (!least) return least.error();
  const Result<double> most = Setting("limit.max");
  if (!most) return most.error();
  steps_per_radian_ = *turn / (2 * kPi);
  const AxisLimits& limits = settings_.limits;
  const auto [low, high] = std::minmax({ToPosition(*least), ToPosition(*most)});
  if (limits.min_position < low || limits.max_position > high) {
    return Fail(
        ErrorCode::kRefused,
        fmt::format("limits of {:.6g} to {:.6g} deg are outside the controller's own, {:.6g} "
                    "to {:.6g} deg (limit.min, limit.max)",
                    DegFromRad(limits.min_position), DegFromRad(limits.max_position),
                    DegFromRad(low), DegFromRad(high)));
  }
  return {};
}

Result<void> ZaberAxis::SetSpeed() {
  const AxisLimits& limits = settings_.limits;
  const auto set = Set("maxspeed", limits.max_speed * steps_per_radian_ * kSpeedUnit);
  if (!set) return set;
  return Set("accel", limits.acceleration * steps_per_radian_ * kAccelerationUnit);
}

Result<Message> ZaberAxis::Ask(const std::string& query) {
  const Result<Message> reply = chain_->Query(settings_.device, settings_.axis, query);
  return reply ? reply : Fail(reply.error().code, reply.error().message);
}

Result<Message> ZaberAxis::Tell(const std::string& command) {
  const Result<Message> reply = chain_->Command(settings_.device, settings_.axis, command);
  return reply ? reply : Fail(reply.error().code, reply.error().message);
}

Result<double> ZaberAxis::Setting(const std::string& setting) {
  const Result<Message> reply = Ask("get " + setting);
  return reply ? NumberOf(*reply, setting) : reply.error();
}

Result<double> ZaberAxis::NumberOf(const Message& reply, const std::string& setting) const {
  const std::string& text = reply.data;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return Fail(ErrorCode::kProtocol, fmt::format("{} is \"{}\", not a number", setting, text));
  }
  return value;
}

Result<void> ZaberAxis::Set(const std::string& setting, double value) {
  const auto asked = std::llround(value);
  if (asked < 1) {
    return Fail(ErrorCode::kRefused,
                fmt::format("{} would be {}: too slow for it", setting, asked));
  }
  const Result<Message> set = Tell(fmt::format("set {} {}", setting, asked));
  if (!set) return set.error();
  const Result<double> got = Setting(setting);
  if (!got) return got.error();
  if (std::abs(*got - value) > kRounding * value + 1) {
    return Fail(ErrorCode::kRefused,
                fmt::format("{} was set to {} and reads {}", setting, asked, *got));
  }
  return {};
}

Result<AxisState> ZaberAxis::State() {
  const Result<Message> reply = Ask("get pos");
  if (!reply) return reply.error();
  const Result<double> steps = NumberOf(*reply, "pos");
  if (!steps) return steps.error();
  AxisState state{.position = ToPosition(*steps), .homed = true, .moving = reply->busy};
  // The reply shows the gravest flag only; behind a fault there may be a lost reference.
  if (LostReference(reply->warning)) {
    state.homed = false;
  } else if (!reply->warning.empty()) {
    const Result<Message> all = Ask("warnings");
    if (!all) return all.error();
    const std::string& flags = all->data;
    state.homed = flags.find("WR") == std::string::npos && flags.find("WH") == std::string::npos;
  }
  return state;
}

Result<void> ZaberAxis::Home(std::stop_token stop) {
  if (const Result<Message> told = Tell("home"); !told) return told.error();
  const Result<Message> idle = WaitForIdle(settings_.home_limit, stop, "homing");
  if (!idle) return idle.error();
  const Result<AxisState> state = State();
  if (!state) return state.error();
  if (!state->homed) return Fail(ErrorCode::kProtocol, "has no reference after homing");
  return {};
}

Result<void> ZaberAxis::StartMove(double position) {
  const AxisLimits& limits = settings_.limits;
  if (!(position >= limits.min_position && position <= limits.max_position)) {
    return Fail(ErrorCode::kRefused,
                fmt::format("{:.6g} deg is outside its limits of {:.6g} to {:.6g} deg",
                            DegFromRad(position), DegFromRad(limits.min_position),
                            DegFromRad(limits.max_position)));
  }
  const Result<AxisState> state = State();
  if (!state) return state.error();
  if (!state->homed) return Fail(ErrorCode::kRefused, "is not homed");
  const Result<Message> told = Tell(fmt::format("move abs {}", std::llround(ToSteps(position))));
  if (!told) return told.error();
  target_ = position;
  return {};
}

Result<void> ZaberAxis::WaitUntilStill(Seconds limit, std::stop_token stop) {
  const Result<Message> idle = WaitForIdle(limit, stop, "a move");
  if (!idle) return idle.error();
  return CheckArrival();
}

Result<Message> ZaberAxis::WaitForIdle(Seconds limit, std::stop_token stop, const char* doing) {
  const Seconds begin = clock_->Now();
  while (true) {
    const Result<Message> status = Ask("");
    if (!status) return status;
    if (IsFault(status->warning)) {
      (void)Stop();
      return Fail(ErrorCode::kProtocol,
                  fmt::format("{} ended with fault {}", doing, status->warning));
    }
    if (!status->busy) return status;
    const Seconds left = limit - (clock_->Now() - begin);
    if (stop.stop_requested() || left <= Seconds::zero()) {
      if (const Result<void> stopped = Stop(); !stopped) return stopped.error();
      if (stop.stop_requested()) {
        return Fail(ErrorCode::kCancelled, fmt::format("{} was cancelled", doing));
      }
      return Fail(ErrorCode::kTimeout, fmt::format("{} took over {:.3g} s", doing, limit.count()));
    }
    clock_->SleepFor(std::min(kPoll, left), stop);
  }
}

// IDLE says that it stands, not where.
Result<void> ZaberAxis::CheckArrival() {
  const Result<AxisState> state = State();
  if (!state) return state.error();
  if (!state->homed) return Fail(ErrorCode::kProtocol, "lost its reference on the way");
  if (std::abs(state->position - target_) <= settings_.limits.position_tolerance) return {};
  return Fail(ErrorCode::kProtocol, fmt::format("stands at {:.6g} deg instead of {:.6g} deg",
                                                DegFromRad(state->position), DegFromRad(target_)));
}

Result<void> ZaberAxis::Stop() {
  if (const Result<Message> told = Tell("stop"); !told) return told.error();
  const Seconds begin = clock_->Now();
  while (clock_->Now() - begin < kStopLimit) {
    const Result<Message> status = Ask("");
    if (!status) return status.error();
    if (!status->busy) return {};
    clock_->SleepFor(kPoll);
  }
  return Fail(ErrorCode::kTimeout,
              fmt::format("still moves {:.3g} s after it was told to stop", kStopLimit.count()));
}

double ZaberAxis::ToSteps(double position) const {
  return (settings_.turned ? -1 : 1) * (position - settings_.zero) * steps_per_radian_;
}

double ZaberAxis::ToPosition(double steps) const {
  return settings_.zero + (settings_.turned ? -1 : 1) * steps / steps_per_radian_;
}

Error ZaberAxis::Fail(ErrorCode code, const std::string& what) const {
  return {code, settings_.name + ": " + what};
}

}  // namespace gonio::zaber
