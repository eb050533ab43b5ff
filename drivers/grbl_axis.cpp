// SPDX-License-Identifier: Apache-2.0
#include "drivers/grbl_axis.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "core/units.h"

namespace gonio::grbl {
namespace {

// Settings of the machine, and of its first axis.
constexpr int kStepIdleDelay = 1;
constexpr int kInches = 13;
constexpr int kSoftLimits = 20;
constexpr int kHoming = 22;
constexpr int kHomingDirections = 23;
constexpr int kMaxRate = 110;
constexpr int kAcceleration = 120;
constexpr int kMaxTravel = 130;

class Controller final : public MotionController {
 public:
  Controller(std::shared_ptr<Machine> machine, int axis, double speed)
      : machine_(std::move(machine)), axis_(axis), speed_(speed) {}

  std::string Identity() const override {
    return fmt::format("{}, axis {}", machine_->identity(),
                       kAxisLetters[static_cast<std::size_t>(axis_)]);
  }
  Result<ControllerStatus> Status() override { return machine_->Status(axis_); }
  // Motors have power but in its sleep, which ends with a reset.
  Result<void> Enable() override { return machine_->Reset(); }
  Result<void> StartHoming() override { return machine_->StartHoming(axis_); }
  Result<void> StartMove(double position) override {
    return machine_->StartMove(axis_, position, speed_);
  }
  Result<void> StartStop() override { return machine_->Stop(); }
  Result<void> StartEmergencyStop() override { return machine_->EmergencyStop(); }

 private:
  const std::shared_ptr<Machine> machine_;
  const int axis_;
  const double speed_;  // deg/s
};

Error Refused(std::string why) { return {ErrorCode::kRefused, std::move(why)}; }

// A setting that has to be so for positions to be relied on.
struct Need {
  int setting;
  int value;
  const char* otherwise;
};
constexpr Need kNeeds[] = {
    {kHoming, 1, "homing is switched off"},
    {kSoftLimits, 1, "soft limits are switched off"},
    {kStepIdleDelay, 255, "its motors lose their power, and steps, between moves"},
    {kInches, 0, "it reports in inches"},
};

Result<void> CheckNeeds(Machine& machine) {
  for (const Need& need : kNeeds) {
    const Result<double> value = machine.Setting(need.setting);
    if (!value) return value.error();
    if (*value == need.value) continue;
    return Refused(fmt::format("{}: set ${}={}, it is {:.6g}", need.otherwise, need.setting,
                               need.value, *value));
  }
  return {};
}

// Its coordinates end at the switch, from below; firmware built to put its origin there whichever
// end that is at counts upwards from a lower one.
Result<void> CheckTravel(Machine& machine, int axis, const ControllerAxisSettings& settings) {
  const Result<double> travel = machine.Setting(kMaxTravel + axis);
  if (!travel) return travel.error();
  const Result<double> directions = machine.Setting(kHomingDirections);
  if (!directions) return directions.error();
  const bool homes_down =
      *directions >= 0 && *directions < 256 && (static_cast<int>(*directions) >> axis & 1) == 1;
  const bool upwards = machine.HasOption('Z') && homes_down;
  const std::string outside =
      OutsideOf(settings.limits, settings.scale, upwards ? 0 : -*travel, upwards ? *travel : 0);
  if (outside.empty()) return {};
  return Refused(fmt::format("{} (${})", outside, kMaxTravel + axis));
}

Result<void> CheckSpeed(Machine& machine, int axis, const ControllerAxisSettings& settings) {
  const Result<double> rate = machine.Setting(kMaxRate + axis);
  if (!rate) return rate.error();
  const double speed = DegFromRad(settings.limits.max_speed);
  if (60 * speed <= *rate) return {};
  return Refused(
      fmt::format("a speed of {:.6g} deg/s is above its {:.6g} deg/s (${} is {:.6g} "
                  "deg/min)",
                  speed, *rate / 60, kMaxRate + axis, *rate));
}

Result<void> CheckTolerance(Machine& machine, int axis, const ControllerAxisSettings& settings) {
  const Result<double> resolution = machine.Resolution(axis);
  if (!resolution) return resolution.error();
  const double tolerance = DegFromRad(settings.limits.position_tolerance);
  if (tolerance >= *resolution) return {};
  return Refused(fmt::format("a tolerance of {:.3g} deg is finer than its steps, {:.3g} deg",
                             tolerance, *resolution));
}

Result<void> Prepare(Machine& machine, int axis, const ControllerAxisSettings& settings) {
  if (const auto needs = CheckNeeds(machine); !needs) return needs;
  if (const auto travel = CheckTravel(machine, axis, settings); !travel) return travel;
  if (const auto speed = CheckSpeed(machine, axis, settings); !speed) return speed;
  if (const auto fine = CheckTolerance(machine, axis, settings); !fine) return fine;
  return machine.Set(kAcceleration + axis, DegFromRad(settings.limits.acceleration));
}

}  // namespace

Result<std::unique_ptr<Axis>> OpenAxis(std::shared_ptr<Machine> machine, char letter,
                                       const ControllerAxisSettings& settings, Clock* clock) {
  ControllerAxisSettings prepared = settings;
  prepared.scale.units_per_radian = DegFromRad(1);
  const std::size_t axis = kAxisLetters.find(letter);
  const int axes = machine->axes();
  if (axis >= static_cast<std::size_t>(axes)) {
    return Refused(fmt::format("{}: no axis {}, of {}", settings.name, letter,
                               kAxisLetters.substr(0, static_cast<std::size_t>(axes))));
  }
  const int number = static_cast<int>(axis);
  const auto done = Prepare(*machine, number, prepared);
  auto controller = std::make_unique<Controller>(std::move(machine), number,
                                                 DegFromRad(settings.limits.max_speed));
  return OpenedAxis(std::move(controller), done, prepared, clock);
}

}  // namespace gonio::grbl
