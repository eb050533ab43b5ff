// SPDX-License-Identifier: Apache-2.0
#include "drivers/gcs2_axis.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/units.h"
#include "drivers/gcs2_codec.h"
#include "drivers/wire_text.h"

namespace gonio::gcs2 {
namespace {

constexpr double kRounding = 1e-3;     // share by which a setting may come back different
constexpr std::size_t kMostAxes = 32;  // that the bits of the motion status may stand for

class Controller final : public MotionController {
 public:
  Controller(std::shared_ptr<Line> line, const AxisAddress& address,
             const ControllerAxisSettings& settings)
      : line_(std::move(line)),
        address_(address.controller),
        axis_(address.axis),
        settings_(settings) {}

  std::string Identity() const override { return identity_; }
  Result<ControllerStatus> Status() override;
  Result<void> Enable() override;
  Result<void> StartHoming() override;
  Result<void> StartMove(double position) override;
  Result<void> StartStop() override;
  Result<void> StartEmergencyStop() override;

  // Who it is, its axes, unit, limits and speeds: what has to be right before anything moves.
  Result<void> Prepare();

 private:
  // What it is doing, so far as we have told it to.
  enum class Doing { kNothing, kHoming, kMove };

  Result<void> Identify();
  Result<void> FindAxis();
  Result<void> CheckUnit();
  Result<void> CheckLimits();
  Result<void> FindEnable();
  Result<void> SetSpeeds();
  Result<void> Set(const std::string& setting, double value);
  Result<bool> Enabled();
  // Sends it, unless a stop comes first.
  Result<void> Start(Doing doing, const std::string& command);
  void NoteStop();
  Result<void> Tell(const std::string& command) { return line_->Command(address_, command); }
  Result<double> Number(const std::string& question) {
    return line_->Number(address_, question, axis_);
  }
  Result<bool> Flag(const std::string& question) { return line_->Flag(address_, question, axis_); }

  const std::shared_ptr<Line> line_;
  const int address_;
  const std::string axis_;
  const ControllerAxisSettings settings_;
  std::string identity_;
  unsigned moving_bit_ = 1;
  bool has_enable_ = false;  // EAX
  std::mutex mutex_;         // of what follows: stops come from any thread
  Doing doing_ = Doing::kNothing;
  bool homing_failed_ = false;  // or has not ended
  int stops_ = 0;
  int faults_forgiven_ = 0;
};

Result<ControllerStatus> Controller::Status() {
  // Whether it moves comes first: then the position of one that does not is its last.
  const Result<unsigned> moving = line_->Moving(address_);
  if (!moving) return moving.error();
  const Result<bool> on_target = Flag("ONT?");
  if (!on_target) return on_target.error();
  const Result<double> position = Number("POS?");
  if (!position) return position.error();
  const Result<bool> referenced = Flag("FRF?");
  if (!referenced) return referenced.error();
  const Result<bool> enabled = Enabled();
  if (!enabled) return enabled.error();
  if (const auto read = line_->ReadErrors(address_); !read) return read.error();

  const std::lock_guard lock(mutex_);
  const bool turns = (*moving & moving_bit_) != 0;
  const bool settles = doing_ == Doing::kMove && *enabled && !*on_target;
  if (doing_ == Doing::kHoming && !turns) {
    doing_ = Doing::kNothing;
    homing_failed_ = !*referenced;
  }
  return ControllerStatus{.position = *position,
                          .homed = *referenced && !homing_failed_,
                          .moving = turns || settles,
                          .enabled = *enabled,
                          .fault = line_->FaultAfter(faults_forgiven_, address_)};
}

Result<bool> Controller::Enabled() {
  const Result<bool> servo = Flag("SVO?");
  return servo && *servo && has_enable_ ? Flag("EAX?") : servo;
}

Result<void> Controller::Enable() {
  if (has_enable_) {
    if (const auto enabled = Tell(fmt::format("EAX {} 1", axis_)); !enabled) return enabled;
  }
  return Tell(fmt::format("SVO {} 1", axis_));
}

Result<void> Controller::StartHoming() {
  if (const auto set = SetSpeeds(); !set) return set;
  {
    const std::lock_guard lock(mutex_);
    homing_failed_ = true;
    faults_forgiven_ = line_->faults();
  }
  return Start(Doing::kHoming, fmt::format("FRF {}", axis_));
}

Result<void> Controller::StartMove(double position) {
  return Start(Doing::kMove, fmt::format("MOV {} {:.6f}", axis_, position));
}

Result<void> Controller::Start(Doing doing, const std::string& command) {
  int stops = 0;
  {
    const std::lock_guard lock(mutex_);
    doing_ = Doing::kNothing;
    stops = stops_;
  }
  const auto told = Tell(command);
  if (!told) return told;
  const std::lock_guard lock(mutex_);
  if (stops_ == stops) doing_ = doing;
  return {};
}

// Before a stop is sent: the end it puts to homing must not be taken for the good one.
void Controller::NoteStop() {
  const std::lock_guard lock(mutex_);
  ++stops_;
  doing_ = Doing::kNothing;
}

Result<void> Controller::StartStop() {
  NoteStop();
  return line_->Halt(address_, axis_);
}

Result<void> Controller::StartEmergencyStop() {
  NoteStop();
  return line_->StopAll(address_);
}

Result<void> Controller::Identify() {
  const Result<std::string> identity = line_->Identity(address_);
  if (!identity) return identity.error();
  const Result<double> syntax = line_->Syntax(address_);
  if (!syntax) return syntax.error();
  if (*syntax < 2) {
    return Error{ErrorCode::kRefused, fmt::format("speaks GCS {:.1f}, not 2.0", *syntax)};
  }
  const Result<bool> ready = line_->IsReady(address_);
  if (!ready) return ready.error();
  if (!*ready) return Error{ErrorCode::kRefused, "the controller is not ready"};
  identity_ = fmt::format("{}, axis {}", *identity, axis_);
  return {};
}

Result<void> Controller::FindAxis() {
  const Result<std::vector<std::string>> axes = line_->Axes(address_);
  if (!axes) return axes.error();
  const auto found = std::find(axes->begin(), axes->end(), axis_);
  const auto place = static_cast<std::size_t>(found - axes->begin());
  if (found == axes->end() || place >= kMostAxes) {
    return Error{ErrorCode::kRefused,
                 fmt::format("the controller has no axis {}, but {}", axis_,
                             Quoted(fmt::format("{}", fmt::join(*axes, " "))))};
  }
  moving_bit_ = 1u << place;
  return {};
}

Result<void> Controller::CheckUnit() {
  const Result<std::string> unit = line_->Unit(address_, axis_);
  if (!unit && unit.error().code != ErrorCode::kRefused) return unit.error();
  if (!unit) {
    identity_ += ", does not tell its unit";
  } else if (!IsDegrees(*unit)) {
    return Error{ErrorCode::kRefused,
                 fmt::format("axis {} counts in {}, not in degrees", axis_, Quoted(*unit))};
  }
  return {};
}

Result<void> Controller::CheckLimits() {
  const Result<double> least = Number("TMN?");
  if (!least) return least.error();
  const Result<double> most = Number("TMX?");
  if (!most) return most.error();
  const std::string outside = OutsideOf(settings_.limits, settings_.scale, *least, *most);
  if (!outside.empty()) return Error{ErrorCode::kRefused, outside + " (TMN?, TMX?)"};
  return {};
}

// Some have motors that must be enabled before their servo.
Result<void> Controller::FindEnable() {
  const Result<bool> enabled = Flag("EAX?");
  if (!enabled && enabled.error().code != ErrorCode::kRefused) return enabled.error();
  has_enable_ = enabled.ok();
  return {};
}

Result<void> Controller::SetSpeeds() {
  const double acceleration = DegFromRad(settings_.limits.acceleration);
  if (const auto set = Set("VEL", DegFromRad(settings_.limits.max_speed)); !set) return set;
  if (const auto set = Set("ACC", acceleration); !set) return set;
  return Set("DEC", acceleration);
}

Result<void> Controller::Set(const std::string& setting, double value) {
  const auto set = Tell(fmt::format("{} {} {:.6f}", setting, axis_, value));
  if (!set) return set;
  const Result<double> got = Number(setting + "?");
  if (!got) return got.error();
  return ReadBackAs(setting, value, *got, kRounding * value);
}

Result<void> Controller::Prepare() {
  if (const auto known = Identify(); !known) return known;
  if (const auto found = FindAxis(); !found) return found;
  if (const auto unit = CheckUnit(); !unit) return unit;
  if (const auto limits = CheckLimits(); !limits) return limits;
  if (const auto found = FindEnable(); !found) return found;
  if (const auto set = SetSpeeds(); !set) return set;
  // What was before this opening is not held against the axis.
  faults_forgiven_ = line_->faults();
  return {};
}

}  // namespace

Result<std::unique_ptr<Axis>> OpenAxis(std::shared_ptr<Line> line, const AxisAddress& address,
                                       const ControllerAxisSettings& settings, Clock* clock) {
  ControllerAxisSettings prepared = settings;
  prepared.scale.units_per_radian = DegFromRad(1);
  auto controller = std::make_unique<Controller>(std::move(line), address, prepared);
  const auto done = controller->Prepare();
  return OpenedAxis(std::move(controller), done, prepared, clock);
}

}  // namespace gonio::gcs2
