// SPDX-License-Identifier: Apache-2.0
#include "drivers/zaber_axis.h"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>

#include "core/units.h"
#include "drivers/wire_text.h"

namespace gonio::zaber {
namespace {

constexpr double kSpeedUnit = 1.6384;            // of the data of speeds, per microstep / s
constexpr double kAccelerationUnit = 1.6384e-4;  // of that of accelerations, per microstep / s^2
constexpr double kRounding = 0.01;               // share by which a setting may come back different

bool LostReference(std::string_view warnings) {
  return warnings.find("WR") != std::string_view::npos ||
         warnings.find("WH") != std::string_view::npos;
}

bool WithoutPower(const std::string& warning) {
  return warning == "FO" || warning == "FD" || warning == "FH" || warning == "FV";
}

// Flags that end a move short of its target. A stop we asked for (NI) is none.
bool IsFault(const std::string& warning) {
  return !warning.empty() && (warning.front() == 'F' || warning == "WL");
}

class Controller final : public MotionController {
 public:
  Controller(std::shared_ptr<Chain> chain, const Address& address)
      : chain_(std::move(chain)), address_(address) {}

  std::string Identity() const override { return identity_; }
  Result<ControllerStatus> Status() override;
  Result<void> Enable() override { return Tell("driver enable"); }
  Result<void> StartHoming() override { return Tell("home"); }
  Result<void> StartMove(double position) override {
    return Tell(fmt::format("move abs {}", std::llround(position)));
  }
  Result<void> StartStop() override { return Tell("stop"); }
  Result<void> StartEmergencyStop() override { return Tell("estop"); }

  Result<void> Identify();
  Result<double> Setting(const std::string& setting);
  Result<void> Set(const std::string& setting, double value);

 private:
  Result<Message> Ask(const std::string& query) {
    return chain_->Query(address_.device, address_.axis, query);
  }
  Result<void> Tell(const std::string& command) {
    const Result<Message> reply = chain_->Command(address_.device, address_.axis, command);
    return reply ? Result<void>() : reply.error();
  }

  const std::shared_ptr<Chain> chain_;
  const Address address_;
  std::string identity_;
};

Result<ControllerStatus> Controller::Status() {
  const Result<Message> reply = Ask("get pos");
  if (!reply) return reply.error();
  const Result<double> position = NumberIn(reply->data, "pos");
  if (!position) return position.error();
  ControllerStatus status{.position = *position,
                          .homed = !LostReference(reply->warning),
                          .moving = reply->busy,
                          .fault = {}};
  if (WithoutPower(reply->warning)) {
    status.enabled = false;
    status.emergency = reply->warning == "FH";
  } else if (IsFault(reply->warning)) {
    status.fault = "fault " + reply->warning;
  }
  // A reply shows the gravest flag only; behind it there may be a lost reference.
  if (status.homed && !reply->warning.empty()) {
    const Result<Message> all = Ask("warnings");
    if (!all) return all.error();
    status.homed = !LostReference(all->data);
  }
  return status;
}

// Of the device, which serves all of its axes.
Result<void> Controller::Identify() {
  std::string values[3];
  const char* const settings[3] = {"deviceid", "system.serial", "version"};
  for (int i = 0; i < 3; ++i) {
    const Result<Message> reply =
        chain_->Query(address_.device, 0, fmt::format("get {}", settings[i]));
    if (!reply) return reply.error();
    values[i] = reply->data;
  }
  identity_ = fmt::format("Zaber device {}, serial {}, firmware {}, axis {}", values[0], values[1],
                          values[2], address_.axis);
  return {};
}

Result<double> Controller::Setting(const std::string& setting) {
  const Result<Message> reply = Ask("get " + setting);
  return reply ? NumberIn(reply->data, setting) : reply.error();
}

Result<void> Controller::Set(const std::string& setting, double value) {
  const auto asked = std::llround(value);
  if (asked < 1) {
    return Error{ErrorCode::kRefused,
                 fmt::format("{} would be {}: too slow for it", setting, asked)};
  }
  if (const auto set = Tell(fmt::format("set {} {}", setting, asked)); !set) return set;
  const Result<double> got = Setting(setting);
  if (!got) return got.error();
  return ReadBackAs(setting, value, *got, kRounding * value + 1);
}

// Scale, limits and speeds: what has to be right before anything moves.
Result<void> Prepare(Controller& controller, ControllerAxisSettings* settings) {
  if (const auto known = controller.Identify(); !known) return known;
  const Result<double> turn = controller.Setting("limit.cycle.dist");
  if (!turn) return turn.error();
  if (!(*turn > 0)) {
    return Error{ErrorCode::kRefused, "not a rotary stage: limit.cycle.dist is 0"};
  }
  settings->scale.units_per_radian = *turn / (2 * kPi);
  const Result<double> least = controller.Setting("limit.min");
  if (!least) return least.error();
  const Result<double> most = controller.Setting("limit.max");
  if (!most) return most.error();
  const std::string outside = OutsideOf(settings->limits, settings->scale, *least, *most);
  if (!outside.empty()) return Error{ErrorCode::kRefused, outside + " (limit.min, limit.max)"};
  const double steps = settings->scale.units_per_radian;
  const auto set = controller.Set("maxspeed", settings->limits.max_speed * steps * kSpeedUnit);
  if (!set) return set;
  return controller.Set("accel", settings->limits.acceleration * steps * kAccelerationUnit);
}

}  // namespace

Result<std::unique_ptr<Axis>> OpenAxis(std::shared_ptr<Chain> chain, const Address& address,
                                       const ControllerAxisSettings& settings, Clock* clock) {
  auto controller = std::make_unique<Controller>(std::move(chain), address);
  ControllerAxisSettings prepared = settings;
  const auto done = Prepare(*controller, &prepared);
  return OpenedAxis(std::move(controller), done, prepared, clock);
}

}  // namespace gonio::zaber
