// SPDX-License-Identifier: Apache-2.0
#include "sim/esp301_emulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "core/units.h"

namespace gonio {
namespace {

constexpr double kTop = 40;           // deg/s
constexpr double kAcceleration = 80;  // deg/s^2
constexpr double kMostAcceleration = 1000;
constexpr Seconds kShortestSearch{1};  // even from the mark it goes to and fro
constexpr std::size_t kQueue = 10;
constexpr int kNoSuchCommand = 6;
constexpr int kEmergencyStop = 4;
constexpr int kNoSuchAxis = 9;
constexpr int kAxisMissing = 37;

}  // namespace

Esp301Emulator::Esp301Emulator(const Esp301Stage& stage, std::shared_ptr<Clock> clock)
    : stage_(stage),
      clock_(std::move(clock)),
      motor_(RadFromDeg(stage.switched_on_at_deg), RadFromDeg(kTop), RadFromDeg(kAcceleration),
             *clock_),
      counter_zero_(motor_.Position()),
      speed_(stage.saved_speed_deg_s) {}

// Commands end with CR, or with a semicolon if another follows. Blanks mean nothing.
std::string Esp301Emulator::Receive(std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  std::string answers;
  for (const char c : bytes) {
    if (c == ' ' || c == '\n') continue;
    if (c != '\r' && c != ';') {
      pending_ += c;
      continue;
    }
    const std::string answer = Answer(std::exchange(pending_, {}));
    if (!answer.empty()) answers += std::exchange(unasked_, {}) + answer + "\r\n";
  }
  return answers;
}

std::string Esp301Emulator::Answer(std::string_view command) {
  if (command.empty()) return {};
  Settle();
  const std::size_t digits = std::min(command.find_first_not_of("0123456789"), command.size());
  const int axis = digits == 0 ? 0 : std::atoi(std::string(command.substr(0, digits)).c_str());
  const std::string name(command.substr(digits, 2));
  const std::string argument(command.substr(std::min(digits + 2, command.size())));
  if (name == "VE") return "ESP301 Version 3.0.1 6/1/99";
  if (name == "TE") return std::to_string(TakeError());
  if (name == "TB") {
    const int code = TakeError();
    return fmt::format("{}, 1234, {}", code, code == 0 ? "NO ERROR DETECTED" : "SOME ERROR");
  }
  if (name == "AB") {
    Halt();
    powered_ = false;
    Queue(kEmergencyStop);
    return {};
  }
  if (digits == 0 || axis != stage_.axis) {
    Queue(digits == 0 ? kAxisMissing : kNoSuchAxis);
    return {};
  }
  return AnswerOfAxis(name, argument);
}

std::string Esp301Emulator::AnswerOfAxis(const std::string& name, const std::string& argument) {
  if (argument != "?") {
    Obey(name, argument);
    return {};
  }
  if (name == "ID") return "URS100CC, SN4711";
  if (name == "SN") return std::to_string(stage_.unit);
  if (name == "SL") return fmt::format("{}", stage_.least_deg);
  if (name == "SR") return fmt::format("{}", stage_.most_deg);
  if (name == "VA") return fmt::format("{}", speed_);
  if (name == "AC") return fmt::format("{}", acceleration_);
  if (name == "AG") return fmt::format("{}", deceleration_);
  if (name == "TP") return fmt::format("{:.5f}", Counter());
  if (name == "MD") return Moving() ? "0" : "1";
  if (name == "MO") return powered_ ? "1" : "0";
  Queue(kNoSuchCommand);
  return {};
}

void Esp301Emulator::Obey(const std::string& name, const std::string& argument) {
  const double number = std::atof(argument.c_str());
  const int own = 100 * stage_.axis;
  if (name == "MO") {
    powered_ = true;
  } else if (name == "MF") {
    Halt();
    powered_ = false;
  } else if (name == "ST") {
    Halt();
  } else if (name == "VA") {
    Set(&speed_, number, stage_.fastest_deg_s, own + 10);
  } else if (name == "AC") {
    Set(&acceleration_, number, kMostAcceleration, own + 11);
  } else if (name == "AG") {
    Set(&deceleration_, number, kMostAcceleration, own + 11);
  } else if (name == "OR" || name == "PA") {
    if (!powered_) {
      Queue(own + 13);
    } else if (searching_) {
      Queue(own + 30);
    } else if (name == "OR") {
      SearchHome();
    } else if (number > stage_.most_deg || number < stage_.least_deg) {
      Queue(own + (number > stage_.most_deg ? 6 : 7));
    } else {
      Move(number);
    }
  } else {
    Queue(kNoSuchCommand);
  }
}

void Esp301Emulator::Set(double* setting, double value, double most, int error) {
  if (value > 0 && value <= most) {
    *setting = value;
  } else {
    Queue(error);
  }
}

void Esp301Emulator::Move(double degrees) {
  motor_.Start(counter_zero_ + RadFromDeg(degrees), speed_ / kTop);
}

void Esp301Emulator::SearchHome() {
  searching_ = true;
  motor_.Start(0, 0.25);
  search_ends_ = clock_->Now() + std::max(motor_.Remaining(), kShortestSearch);
}

// A search that has run to its end makes the mark the new zero.
void Esp301Emulator::Settle() {
  if (!searching_ || Moving()) return;
  searching_ = false;
  counter_zero_ = 0;
}

void Esp301Emulator::Halt() {
  Settle();
  if (searching_ && Moving()) Queue(100 * stage_.axis + 20);
  searching_ = false;
  motor_.Stop();
}

bool Esp301Emulator::Moving() const {
  return searching_ ? clock_->Now() < search_ends_ : motor_.Moving();
}

double Esp301Emulator::Counter() const { return DegFromRad(motor_.Position() - counter_zero_); }

void Esp301Emulator::Queue(int code) {
  if (errors_.size() < kQueue) errors_.push_back(code);
}

int Esp301Emulator::TakeError() {
  if (errors_.empty()) return 0;
  const int code = errors_.front();
  errors_.pop_front();
  return code;
}

void Esp301Emulator::Reset() {
  const std::lock_guard lock(mutex_);
  motor_.Stop();
  searching_ = powered_ = false;
  errors_.clear();
  counter_zero_ = motor_.Position();
  speed_ = stage_.saved_speed_deg_s;
}

void Esp301Emulator::CutMotorPower() {
  const std::lock_guard lock(mutex_);
  Halt();
  powered_ = false;
}

void Esp301Emulator::Fail(int number) {
  const std::lock_guard lock(mutex_);
  Halt();
  Queue(100 * stage_.axis + number);
}

void Esp301Emulator::QueueError(int code) {
  const std::lock_guard lock(mutex_);
  Queue(code);
}

void Esp301Emulator::Blurt(std::string_view line) {
  const std::lock_guard lock(mutex_);
  unasked_ += fmt::format("{}\r\n", line);
}

}  // namespace gonio
