// SPDX-License-Identifier: Apache-2.0
#include "drivers/apt_axis.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <utility>

#include "core/units.h"
#include "drivers/apt_stages.h"

namespace gonio::apt {
namespace {

constexpr Seconds kDwell{0.05};     // before and after what came is thrown away, as the manual asks
constexpr Seconds kEnableTime{1};   // TDC001 hangs if it is told to move sooner after being enabled
constexpr Seconds kSluggish{1};     // until the status shows what was commanded
constexpr double kRounding = 0.01;  // share by which a setting may come back different
constexpr int kEnable = 1;          // of SET_CHANENABLESTATE
constexpr int kAtOnce = 1;          // of MOVE_STOP
constexpr int kProfiled = 2;

constexpr double kLeastLong = std::numeric_limits<std::int32_t>::min();
constexpr double kMostLong = std::numeric_limits<std::int32_t>::max();

// A value of VELPARAMS. kRefused: none of those there are.
Result<std::int32_t> Setting(const char* what, double value) {
  if (!(value >= 0.5 && value <= kMostLong)) {
    return Error{ErrorCode::kRefused,
                 fmt::format("{} would be {:.6g}: it has 1 to {:.0f}", what, value, kMostLong)};
  }
  return static_cast<std::int32_t>(std::llround(value));
}

bool IsClose(std::int32_t got, std::int32_t asked) {
  return std::abs(static_cast<double>(got) - asked) <= kRounding * asked + 1;
}

class Controller final : public MotionController {
 public:
  Controller(std::shared_ptr<Link> link, const Address& address, const Stage& stage,
             const AxisLimits& limits, Clock* clock)
      : link_(std::move(link)),
        address_(address),
        stage_(stage),
        limits_(limits),
        clock_(clock),
        tolerance_(DegFromRad(limits.position_tolerance) * stage.counts_per_degree + 1) {}

  std::string Identity() const override { return identity_; }
  Result<ControllerStatus> Status() override;
  Result<void> Enable() override;
  Result<void> StartHoming() override;
  Result<void> StartMove(double position) override;
  Result<void> StartStop() override { return Stop(kProfiled); }
  Result<void> StartEmergencyStop() override { return Stop(kAtOnce); }

  Result<void> Identify();
  Result<void> Set();

 private:
  // What the motor was told to do and is not known to have done.
  enum class Errand { kNone, kMove, kHome };

  Result<Message> Ask(Id question, Id answer) {
    return link_->Query(AboutMotor(question, address_), answer);
  }
  Result<void> Tell(const Message& command) { return link_->Command(command, address_); }
  Result<void> SetVelocities();
  Result<void> SetNoBacklash();
  Result<void> Stop(int how);
  Result<void> Send(const Message& command, Errand errand, double target = 0);
  void Begin(Errand errand, double target = 0);
  // What is made of the bits, knowing what it was told to do.
  ControllerStatus Judge(const apt::Status& status);
  std::string FaultOf(std::uint32_t bits, bool ended_short);

  const std::shared_ptr<Link> link_;
  const Address address_;
  const Stage stage_;
  const AxisLimits limits_;
  Clock* const clock_;
  const double tolerance_;  // counts
  std::string identity_;

  std::mutex mutex_;  // stops come from any thread
  Errand errand_ = Errand::kNone;
  double target_ = 0;        // counts, of a move
  Seconds last_turning_{0};  // when the motor was seen turning, or was told to
  bool unhomed_ = false;     // of a homing: what was homed before no longer counts
  bool unproven_ = false;    // a homing was begun, and not ended well
  std::optional<std::uint32_t> interlock_;
};

// A controller without cards is the module itself; of cards the rack knows who they are.
Result<void> Controller::Identify() {
  const bool card = address_.module >= kFirstBay && address_.module <= kLastBay;
  Message question;
  question.id = kHwReqInfo;
  question.dest = card ? kRack : address_.module;
  const Result<Message> answer = link_->Query(question, kHwGetInfo);
  if (!answer) return answer.error();
  const Result<Info> info = DecodeInfo(*answer);
  if (!info) return info.error();
  if (const std::string why = WhyNotDriven(stage_, *info); !why.empty()) {
    return Error{ErrorCode::kRefused, why};
  }
  identity_ = fmt::format("Thorlabs {}, serial {}, firmware {}, module 0x{:02x}, channel {}, as {}",
                          info->model, info->serial, info->firmware, address_.module,
                          address_.channel, stage_.name);
  return {};
}

Result<void> Controller::Set() {
  const auto set = SetVelocities();
  return set ? SetNoBacklash() : set;
}

Result<void> Controller::SetVelocities() {
  const auto most =
      Setting("maximum velocity", DegFromRad(limits_.max_speed) * stage_.velocity_per_degree);
  if (!most) return most.error();
  const auto acceleration =
      Setting("acceleration", DegFromRad(limits_.acceleration) * stage_.acceleration_per_degree);
  if (!acceleration) return acceleration.error();
  const Velocity asked{
      .channel = address_.channel, .least = 0, .acceleration = *acceleration, .most = *most};
  if (const auto set = Tell(SetVelocity(address_.module, asked)); !set) return set;
  const Result<Message> answer = Ask(kReqVelParams, kGetVelParams);
  if (!answer) return answer.error();
  const Result<Velocity> got = DecodeVelocity(*answer);
  if (!got) return got.error();
  if (!IsClose(got->most, asked.most) || !IsClose(got->acceleration, asked.acceleration)) {
    return Error{ErrorCode::kRefused,
                 fmt::format("maximum velocity and acceleration were set to {} and {} and read {} "
                             "and {}",
                             asked.most, asked.acceleration, got->most, got->acceleration)};
  }
  return {};
}

// Else both it and the rig's approach would take it up.
Result<void> Controller::SetNoBacklash() {
  std::int32_t distance = 0;
  for (int i = 0; i < 2; ++i) {
    const Result<Message> answer = Ask(kReqGenMoveParams, kGetGenMoveParams);
    if (!answer) return answer.error();
    const Result<Backlash> got = DecodeBacklash(*answer);
    if (!got) return got.error();
    distance = got->distance;
    if (distance == 0) return {};
    if (i > 0) break;
    const auto set =
        Tell(SetBacklash(address_.module, {.channel = address_.channel, .distance = 0}));
    if (!set) return set;
  }
  return Error{ErrorCode::kRefused,
               fmt::format("its backlash distance was set to 0 and reads {}", distance)};
}

Result<ControllerStatus> Controller::Status() {
  // Servo controllers fall silent after some fifty statuses that nobody acknowledged; controllers
  // of stepper motors do not know the acknowledgement, and complain.
  if (stage_.servo) {
    const auto told =
        link_->Tell(AboutMotor(kAckDcStatusUpdate, {.module = address_.module, .channel = 0}));
    if (!told) return told.error();
  }
  const Result<Message> answer = stage_.servo ? Ask(kReqDcStatusUpdate, kGetDcStatusUpdate)
                                              : Ask(kReqStatusUpdate, kGetStatusUpdate);
  if (!answer) return answer.error();
  const Result<apt::Status> status = DecodeStatus(*answer);
  if (!status) return status.error();
  ControllerStatus judged = Judge(*status);
  if (judged.fault.empty()) judged.fault = link_->ReportOf(address_.module);
  return judged;
}

// The status may show with a delay that the motor was told something: until then, and while it
// settles, it counts as moving.
ControllerStatus Controller::Judge(const apt::Status& status) {
  const std::lock_guard lock(mutex_);
  const bool turning = (status.bits & kTurning) != 0;
  const bool homed = (status.bits & kHomed) != 0;
  const bool enabled = (status.bits & kEnabled) != 0;
  if (turning) last_turning_ = clock_->Now();
  // Where it stands at its mark already, homing may be over before a status could show it.
  if (!homed || (status.bits & kHoming) != 0 || link_->HasHomed(address_)) unhomed_ = true;
  const bool done = errand_ == Errand::kMove ? std::abs(status.position - target_) <= tolerance_
                                             : unhomed_ && homed;
  const bool waiting =
      errand_ != Errand::kNone && !done && enabled && clock_->Now() - last_turning_ < kSluggish;
  const bool moving = turning || waiting;
  const bool ended_short = errand_ == Errand::kMove && !moving && !done;
  if (!moving) {
    if (errand_ == Errand::kHome && done) unproven_ = false;
    errand_ = Errand::kNone;
  }
  return {.position = static_cast<double>(status.position),
          .homed = homed && !unproven_,
          .moving = moving,
          .enabled = enabled,
          .fault = FaultOf(status.bits, ended_short)};
}

// A switch is no fault as long as the motor need not go there: some stages have theirs at the
// reference mark, and pass over it. Nor is an interlock, of which controllers do not agree whether
// the bit means open or closed: but none changes by itself.
std::string Controller::FaultOf(std::uint32_t bits, bool ended_short) {
  std::string fault = FaultsIn(bits);
  const auto add = [&](const char* text) {
    fault += (fault.empty() ? "" : ", ") + std::string(text);
  };
  if (ended_short && (bits & kLimitSwitches) != 0) add("stopped at a limit switch");
  if (ended_short && (bits & kSoftLimits) != 0) add("stopped at a soft limit");
  if (!interlock_) interlock_ = bits & kInterlock;
  if ((bits & kInterlock) != *interlock_) add("its interlock has changed");
  return fault;
}

// Noted before it is sent, so that a stop from another thread has the last word.
Result<void> Controller::Send(const Message& command, Errand errand, double target) {
  Begin(errand, target);
  const auto told = Tell(command);
  if (!told) Begin(Errand::kNone);
  return told;
}

void Controller::Begin(Errand errand, double target) {
  const std::lock_guard lock(mutex_);
  errand_ = errand;
  target_ = target;
  last_turning_ = clock_->Now();
  if (errand == Errand::kHome) {
    unproven_ = true;
    unhomed_ = false;
    interlock_.reset();
  }
}

Result<void> Controller::Enable() {
  const auto told = Tell(AboutMotor(kSetChanEnableState, address_, kEnable));
  if (told) clock_->SleepFor(kEnableTime);
  return told;
}

Result<void> Controller::StartHoming() {
  const Result<Message> answer = Ask(kReqHomeParams, kGetHomeParams);
  if (!answer) return answer.error();
  const Result<Homing> homing = DecodeHoming(*answer);
  if (!homing) return homing.error();
  if (homing->velocity <= 0) {
    return Error{
        ErrorCode::kRefused,
        fmt::format("its homing velocity is {}, so that homing would not end: set one with "
                    "the maker's program",
                    homing->velocity)};
  }
  if (const auto set = Set(); !set) return set;
  link_->Forget(address_.module);
  return Send(AboutMotor(kMoveHome, address_), Errand::kHome);
}

// Targets lie within limits that its counter holds.
Result<void> Controller::StartMove(double position) {
  return Send(MoveTo(address_, static_cast<std::int32_t>(std::llround(position))), Errand::kMove,
              std::round(position));
}

Result<void> Controller::Stop(int how) {
  Begin(Errand::kNone);
  return Tell(AboutMotor(kMoveStop, address_, how));
}

// Who it is, its scale, and speeds: what has to be right before anything moves.
Result<void> Prepare(Controller& controller, const ControllerAxisSettings& settings) {
  if (const auto known = controller.Identify(); !known) return known;
  const std::string outside = OutsideOf(settings.limits, settings.scale, kLeastLong, kMostLong);
  if (!outside.empty()) return Error{ErrorCode::kRefused, outside + " (what its counter holds)"};
  return controller.Set();
}

}  // namespace

Result<std::unique_ptr<SerialPort>> OpenPort(const SerialSettings& settings, Clock* clock) {
  Result<std::unique_ptr<SerialPort>> opened = SerialPort::Open(settings);
  if (!opened) return opened;
  // While nobody listened the controller held back what it had to say, and now says it.
  for (int i = 0; i < 2; ++i) {
    clock->SleepFor(kDwell);
    if (const auto discarded = (*opened)->DiscardInput(); !discarded) return discarded.error();
  }
  return opened;
}

Result<std::unique_ptr<Axis>> OpenAxis(std::shared_ptr<Link> link, const Address& address,
                                       std::string_view stage,
                                       const ControllerAxisSettings& settings, Clock* clock) {
  const Result<Stage> known = FindStage(stage);
  if (!known) return Error{known.error().code, settings.name + ": " + known.error().message};
  ControllerAxisSettings prepared = settings;
  prepared.scale.units_per_radian = known->counts_per_degree * DegFromRad(1);
  auto controller =
      std::make_unique<Controller>(std::move(link), address, *known, settings.limits, clock);
  const auto done = Prepare(*controller, prepared);
  return OpenedAxis(std::move(controller), done, prepared, clock);
}

}  // namespace gonio::apt
