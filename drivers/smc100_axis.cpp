// SPDX-License-Identifier: Apache-2.0
#include "drivers/smc100_axis.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/units.h"
#include "drivers/asked_twice.h"
#include "drivers/smc100_codec.h"
#include "drivers/wire_text.h"

namespace gonio::smc100 {
namespace {

constexpr double kRounding = 1e-3;  // share by which a setting may come back different

class Controller final : public MotionController {
 public:
  Controller(std::shared_ptr<Line> line, int address, const AxisLimits& limits)
      : line_(std::move(line)), address_(address), limits_(limits) {}

  std::string Identity() const override { return identity_; }
  Result<ControllerStatus> Status() override;
  Result<void> Enable() override { return line_->Command(address_, "MM1"); }
  Result<void> StartHoming() override;
  Result<void> StartMove(double position) override {
    return line_->Command(address_, fmt::format("PA{:.6f}", position));
  }
  Result<void> StartStop() override { return line_->Stop(address_); }
  // It knows one way of stopping.
  Result<void> StartEmergencyStop() override { return StartStop(); }

  Result<void> Identify();
  Result<double> Number(const std::string& command, const std::string& argument);
  Result<void> SetSpeeds();

 private:
  Result<void> Set(const std::string& setting, double value);

  const std::shared_ptr<Line> line_;
  const int address_;
  const AxisLimits limits_;
  std::string identity_;
};

Result<ControllerStatus> Controller::Status() {
  const Result<std::string> answer = line_->Query(address_, "TS", "");
  if (!answer) return answer.error();
  const Result<smc100::Status> status = DecodeStatus(*answer);
  if (!status) return status.error();
  // After the state: of one that has arrived it is where it arrived.
  const Result<double> position = Number("TP", "");
  if (!position) return position.error();
  const State state = status->state;
  return ControllerStatus{
      .position = *position,
      .homed = state != State::kNotReferenced && state != State::kConfiguration &&
               state != State::kHoming,
      .moving = state == State::kHoming || state == State::kMoving || state == State::kJogging,
      .enabled = state != State::kDisabled,
      .fault = TextOf(status->errors)};
}

// One that has a reference refuses to look for it again.
Result<void> Controller::StartHoming() {
  const Result<ControllerStatus> status = Status();
  if (!status) return status.error();
  if (const auto set = SetSpeeds(); !set) return set;
  return status->homed ? Result<void>() : line_->Command(address_, "OR");
}

Result<void> Controller::Identify() {
  const Result<std::string> version = line_->Query(address_, "VE", "");
  if (!version) return version.error();
  identity_ = fmt::format("Newport{}, address {}", *version, address_);
  return {};
}

Result<double> Controller::Number(const std::string& command, const std::string& argument) {
  const Result<std::string> answer = line_->Query(address_, command, argument);
  return answer ? NumberIn(*answer, command) : answer.error();
}

// Those of before are back after a reset.
Result<void> Controller::SetSpeeds() {
  if (const auto set = Set("VA", DegFromRad(limits_.max_speed)); !set) return set;
  return Set("AC", DegFromRad(limits_.acceleration));
}

Result<void> Controller::Set(const std::string& setting, double value) {
  const auto set = line_->Command(address_, fmt::format("{}{:.6f}", setting, value));
  if (!set) return set;
  const Result<double> got = Number(setting, "?");
  if (!got) return got.error();
  return ReadBackAs(setting, value, *got, kRounding * value);
}

Result<void> Prepare(Controller& controller, const ControllerAxisSettings& settings) {
  if (const auto known = controller.Identify(); !known) return known;
  const Result<double> least = controller.Number("SL", "?");
  if (!least) return least.error();
  const Result<double> most = controller.Number("SR", "?");
  if (!most) return most.error();
  const std::string outside = OutsideOf(settings.limits, settings.scale, *least, *most);
  if (!outside.empty()) return Error{ErrorCode::kRefused, outside + " (SL, SR)"};
  return controller.SetSpeeds();
}

}  // namespace

Line::Line(std::unique_ptr<ByteLink> link, Seconds reply_limit)
    : link_(std::move(link)), lines_(link_.get()), reply_limit_(reply_limit) {}

Result<std::string> Line::Query(int address, const std::string& command,
                                const std::string& argument) {
  const std::lock_guard lock(mutex_);
  return AskedTwice([&] { return Exchange(address, command, argument); });
}

Result<void> Line::Command(int address, const std::string& command) {
  const std::lock_guard lock(mutex_);
  // An error left over from before must not be taken for this command's.
  if (const auto before = Exchange(address, "TE", ""); !before) return before.error();
  const auto sent = link_->Write(Encode(address, command), reply_limit_);
  if (!sent) return sent.error();
  const Result<std::string> error = Exchange(address, "TE", "");
  if (!error) return error.error();
  const std::string why = error->size() == 1 ? TextOfCommandError(error->front()) : Quoted(*error);
  if (why.empty()) return {};
  return Error{ErrorCode::kRefused,
               fmt::format("{}: address {} refused {}: {}", link_->name(), address, command, why)};
}

Result<void> Line::Stop(int address) {
  const std::lock_guard lock(mutex_);
  const auto sent = link_->Write(Encode(address, "ST"), reply_limit_);
  if (!sent) return sent;
  const Result<std::string> error = Exchange(address, "TE", "");
  return error ? Result<void>() : error.error();
}

Result<std::string> Line::Exchange(int address, const std::string& command,
                                   const std::string& argument) {
  if (const Result<void> discarded = lines_.Discard(); !discarded) return discarded.error();
  const auto sent = link_->Write(Encode(address, command + argument), reply_limit_);
  if (!sent) return sent.error();
  const Result<std::string> line = lines_.Next(reply_limit_);
  if (!line) {
    return Error{line.error().code,
                 fmt::format("{}, address {}, asked {}", line.error().message, address, command)};
  }
  Result<std::string> answer = AnswerTo(address, command, *line);
  if (answer) return answer;
  return Error{answer.error().code, fmt::format("{}: {}", link_->name(), answer.error().message)};
}

Result<std::unique_ptr<Axis>> OpenAxis(std::shared_ptr<Line> line, int address,
                                       const ControllerAxisSettings& settings, Clock* clock) {
  auto controller = std::make_unique<Controller>(std::move(line), address, settings.limits);
  ControllerAxisSettings prepared = settings;
  prepared.scale.units_per_radian = DegFromRad(1);
  const auto done = Prepare(*controller, prepared);
  return OpenedAxis(std::move(controller), done, prepared, clock);
}

}  // namespace gonio::smc100
