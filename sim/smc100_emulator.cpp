// SPDX-License-Identifier: Apache-2.0
#include "sim/smc100_emulator.h"

#include <fmt/format.h>

#include <cstdlib>
#include <utility>

#include "core/units.h"

namespace gonio {
namespace {

constexpr double kTop = 40;           // deg/s
constexpr double kAcceleration = 80;  // deg/s^2
// After power-up.
constexpr double kSavedVelocity = 20;
constexpr double kSavedAcceleration = 80;

}  // namespace

Smc100Emulator::Smc100Emulator(const Smc100Stage& stage, std::shared_ptr<Clock> clock)
    : stage_(stage),
      clock_(std::move(clock)),
      motor_(RadFromDeg(stage.switched_on_at_deg), RadFromDeg(kTop), RadFromDeg(kAcceleration),
             *clock_),
      counter_zero_(motor_.Position()),
      velocity_(kSavedVelocity),
      acceleration_(kSavedAcceleration) {}

std::string Smc100Emulator::Receive(std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  std::string answers;
  for (const char c : bytes) {
    if (c == '\r') continue;
    if (c != '\n') {
      pending_ += c;
      continue;
    }
    const std::string answer = Answer(std::exchange(pending_, {}));
    if (!answer.empty()) answers += answer + "\r\n";
  }
  return answers;
}

std::string Smc100Emulator::Answer(std::string line) {
  char* rest = nullptr;
  const long address = std::strtol(line.c_str(), &rest, 10);
  const std::string command(rest);
  if (address != stage_.address || command.size() < 2) return {};
  const std::string name = command.substr(0, 2);
  const std::string result = Obey(name, command.substr(2));
  return result.empty() ? result : fmt::format("{}{}{}", address, name, result);
}

// Two hexadecimal digits' worth. Also ends what has run its time.
int Smc100Emulator::State() {
  if (homing_ && motor_.Moving()) return 0x1e;
  if (homing_) {
    homing_ = false;
    referenced_ = true;
    moved_ = false;
    counter_zero_ = 0;
  }
  if (!referenced_) return 0x0a;
  if (disabled_) return 0x3d;
  if (motor_.Moving()) return 0x28;
  return moved_ ? 0x33 : 0x32;
}

// The answer, if it is a query.
std::string Smc100Emulator::Obey(const std::string& command, const std::string& argument) {
  const int state = State();
  const double number = std::atof(argument.c_str());
  const bool asked = argument == "?";
  if (command == "TS") return fmt::format("{:04X}{:02X}", errors_, state);
  if (command == "TP") return fmt::format("{:.5f}", DegFromRad(motor_.Position() - counter_zero_));
  if (command == "TE") return std::string(1, std::exchange(error_, '@'));
  if (command == "VE") return " SMC_CC_1.0.1 ";
  if (command == "SL" && asked) return fmt::format("{}", stage_.least_deg);
  if (command == "SR" && asked) return fmt::format("{}", stage_.most_deg);
  if (command == "VA" && asked) return fmt::format("{}", velocity_);
  if (command == "AC" && asked) return fmt::format("{}", acceleration_);
  if (command == "VA" && number > 0 && number <= stage_.fastest_deg_s) {
    velocity_ = number;
  } else if (command == "AC" && number > 0) {
    acceleration_ = number;
  } else if (command == "VA" || command == "AC") {
    error_ = 'C';
  } else if (command == "OR") {
    if (referenced_ || homing_) {
      error_ = referenced_ ? 'K' : 'L';
    } else {
      homing_ = true;
      errors_ = 0;
      motor_.Start(0, 0.25);
    }
  } else if (command == "MM") {
    disabled_ = number != 1;
  } else if (command == "PA") {
    if (state == 0x3d) {
      error_ = 'J';
    } else if (state == 0x0a || state == 0x1e) {
      error_ = state == 0x0a ? 'H' : 'L';
    } else if (number < stage_.least_deg || number > stage_.most_deg) {
      error_ = 'N';
    } else {
      Move(number);
    }
  } else if (command == "ST") {
    if (state == 0x0a) error_ = 'H';
    homing_ = false;
    motor_.Stop();
  } else if (command == "RS") {
    referenced_ = homing_ = false;
    motor_.Stop();
  } else {
    error_ = 'A';
  }
  return {};
}

void Smc100Emulator::Move(double degrees) {
  moved_ = true;
  motor_.Start(counter_zero_ + RadFromDeg(degrees), velocity_ / kTop);
}

void Smc100Emulator::Reset() {
  const std::lock_guard lock(mutex_);
  motor_.Stop();
  velocity_ = kSavedVelocity;
  acceleration_ = kSavedAcceleration;
  referenced_ = homing_ = moved_ = false;
  counter_zero_ = motor_.Position();
}

void Smc100Emulator::CutMotorPower() {
  const std::lock_guard lock(mutex_);
  motor_.Stop();
  disabled_ = true;
}

void Smc100Emulator::Fail(unsigned error_bits) {
  const std::lock_guard lock(mutex_);
  motor_.Stop();
  errors_ = error_bits;
  referenced_ = false;
}

}  // namespace gonio
