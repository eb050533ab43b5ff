// SPDX-License-Identifier: Apache-2.0
#include "sim/gcs2_emulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <utility>

#include "core/units.h"

namespace gonio {
namespace {

constexpr double kTop = 40;           // deg/s
constexpr double kAcceleration = 80;  // deg/s^2
constexpr double kMostAcceleration = 1000;
constexpr Seconds kSettling{0.2};
constexpr double kOvershoot = 0.05;  // deg, gone once it has settled
constexpr int kNoSuchCommand = 2;
constexpr int kNotReferenced = 5;  // or servo off
constexpr int kOutOfLimits = 7;
constexpr int kTooFast = 8;
constexpr int kStopped = 10;
constexpr int kNoSuchAxis = 15;
constexpr int kOutOfRange = 17;
constexpr int kNoSuchParameter = 54;

}  // namespace

// "MOV 1 10.5"
struct Gcs2Emulator::Command {
  std::string name;
  std::string axis;
  std::string argument;

  explicit Command(const std::string& line) {
    std::istringstream(line) >> name >> axis >> argument;
  }
};

Gcs2Emulator::Gcs2Emulator(const Gcs2Stage& stage, std::shared_ptr<Clock> clock)
    : stage_(stage),
      clock_(std::move(clock)),
      motor_(RadFromDeg(stage.switched_on_at_deg), RadFromDeg(kTop), RadFromDeg(kAcceleration),
             *clock_),
      counter_zero_(motor_.Position()),
      speed_(stage.saved_speed_deg_s) {}

std::string Gcs2Emulator::Receive(std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  const std::string called = stage_.address == 0 ? "" : fmt::format("{} ", stage_.address);
  std::string answers;
  for (const char c : bytes) {
    const bool single = c > 0 && c < ' ' && c != '\n';
    if (!single && c != '\n') {
      pending_ += c;
      continue;
    }
    const std::string line = std::exchange(pending_, {});
    if (line.compare(0, called.size(), called) != 0) continue;
    Settle();
    const std::string answer = single ? AnswerByte(c) : Answer(Command(line.substr(called.size())));
    answers += Sent(answer);
  }
  return answers;
}

// On a chain, who it is from and who it is for come first.
std::string Gcs2Emulator::Sent(const std::string& reply) const {
  return reply.empty() || stage_.address == 0 ? reply
                                              : fmt::format("0 {} {}", stage_.address, reply);
}

std::string Gcs2Emulator::AnswerByte(char command) {
  if (command == 0x07) return "\xb1\n";
  if (command == 0x18) Halt();
  if (command != 0x05) return {};
  unsigned moving = 0;
  for (std::size_t i = 0; i < stage_.axes.size(); ++i) {
    if (stage_.axes[i] != stage_.axis || motor_.Moving()) moving |= 1u << i;
  }
  return fmt::format("{:X}\n", moving);
}

std::string Gcs2Emulator::Answer(const Command& command) {
  if (command.name == "*IDN?") {
    return "(c)2015 Physik Instrumente (PI) GmbH & Co. KG, C-863.11, 0018550027, 1.2.1.0\n";
  }
  if (command.name == "CSV?") return "2.0\n";
  if (command.name == "ERR?") {
    if (std::exchange(skip_error_, false)) return "\n";
    return fmt::format("{}\n", std::exchange(error_, 0));
  }
  if (command.name == "SAI?") {
    std::string lines;
    for (const std::string& axis : stage_.axes) {
      lines += axis + (axis == stage_.axes.back() ? "\n" : " \n");
    }
    return lines;
  }
  if (command.axis != stage_.axis) {
    error_ = kNoSuchAxis;
    return {};
  }
  return AnswerOfAxis(command);
}

std::string Gcs2Emulator::AnswerOfAxis(const Command& command) {
  const auto answer = [&](const auto& value) { return fmt::format("{}={}\n", stage_.axis, value); };
  const std::string& name = command.name;
  if (name == "SPA?" && command.argument == "0x07000601" && !stage_.unit.empty()) {
    return fmt::format("{} {}={}\n", stage_.axis, command.argument, stage_.unit);
  }
  if (name == "SPA?") {
    error_ = kNoSuchParameter;
    return {};
  }
  if (name == "POS?") return answer(fmt::format("{:.6f}", Counter()));
  if (name == "ONT?") return answer(OnTarget() ? 1 : 0);
  if (name == "FRF?") return answer(referenced_ ? 1 : 0);
  if (name == "SVO?") return answer(servo_ ? 1 : 0);
  if (name == "EAX?" && stage_.knows_enable) return answer(enabled_ ? 1 : 0);
  if (name == "TMN?") return answer(stage_.least_deg);
  if (name == "TMX?") return answer(stage_.most_deg);
  if (name == "VEL?") return answer(speed_);
  if (name == "ACC?") return answer(acceleration_);
  if (name == "DEC?") return answer(deceleration_);
  Obey(command);
  return {};
}

void Gcs2Emulator::Obey(const Command& command) {
  const double number = std::atof(command.argument.c_str());
  const std::string& name = command.name;
  const auto set = [&](double* setting, double most, int error) {
    if (number > 0 && number <= most) {
      *setting = number;
    } else {
      error_ = error;
    }
  };
  if (name == "VEL") {
    set(&speed_, stage_.fastest_deg_s, kTooFast);
  } else if (name == "ACC" || name == "DEC") {
    set(name == "ACC" ? &acceleration_ : &deceleration_, kMostAcceleration, kOutOfRange);
  } else if (name == "EAX" && stage_.knows_enable) {
    enabled_ = number == 1;
  } else if (name == "SVO") {
    if (number != 1) Halt();
    servo_ = number == 1 && (enabled_ || !stage_.knows_enable);
  } else if (name == "HLT" && stage_.knows_halt) {
    Halt();
  } else if (name == "FRF") {
    if (servo_) {
      Refer();
    } else {
      error_ = kNotReferenced;
    }
  } else if (name == "MOV") {
    if (!servo_ || !referenced_) {
      error_ = kNotReferenced;
    } else if (number < stage_.least_deg || number > stage_.most_deg) {
      error_ = kOutOfLimits;
    } else {
      Move(number);
    }
  } else {
    error_ = kNoSuchCommand;
  }
}

void Gcs2Emulator::Move(double degrees) {
  motor_.Start(counter_zero_ + RadFromDeg(degrees), speed_ / kTop);
  settled_at_ = clock_->Now() + motor_.Remaining() + kSettling;
  settles_from_ = kOvershoot;
}

void Gcs2Emulator::Refer() {
  referenced_ = false;
  referring_ = true;
  settles_from_ = 0;
  motor_.Start(0, 0.25);
}

// Referring that has run to its end makes the switch the new zero.
void Gcs2Emulator::Settle() {
  if (!referring_ || motor_.Moving()) return;
  referring_ = false;
  referenced_ = true;
  counter_zero_ = 0;
}

void Gcs2Emulator::Halt() {
  Settle();
  referring_ = false;
  motor_.Stop();
  settles_from_ = 0;
  error_ = kStopped;
}

bool Gcs2Emulator::OnTarget() const {
  return servo_ && !motor_.Moving() && (settles_from_ == 0 || clock_->Now() >= settled_at_);
}

double Gcs2Emulator::Counter() const {
  const bool settles = !motor_.Moving() && settles_from_ != 0 && clock_->Now() < settled_at_;
  return DegFromRad(motor_.Position() - counter_zero_) + (settles ? settles_from_ : 0);
}

double Gcs2Emulator::Shaft() const { return motor_.Position(); }

void Gcs2Emulator::Reset() {
  const std::lock_guard lock(mutex_);
  Halt();
  referenced_ = servo_ = enabled_ = false;
  error_ = 0;
  counter_zero_ = motor_.Position();
  speed_ = stage_.saved_speed_deg_s;
}

void Gcs2Emulator::CutMotorPower() {
  const std::lock_guard lock(mutex_);
  Halt();
  servo_ = false;
  error_ = 0;
}

void Gcs2Emulator::Fail(int error) {
  const std::lock_guard lock(mutex_);
  Halt();
  servo_ = false;
  error_ = error;
}

void Gcs2Emulator::SkipNextError() {
  const std::lock_guard lock(mutex_);
  skip_error_ = true;
}

}  // namespace gonio
