// SPDX-License-Identifier: Apache-2.0
#include "sim/zaber_emulator.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "core/units.h"

namespace gonio {
namespace {

// What has to be added to the sum of the bytes to make it a multiple of 256.
int Complement(std::string_view bytes) {
  int sum = 0;
  for (const char c : bytes) sum += static_cast<unsigned char>(c);
  return (0x100 - (sum & 0xff)) & 0xff;
}

bool StartsWith(std::string_view text, std::string_view beginning) {
  return text.substr(0, beginning.size()) == beginning;
}

}  // namespace

struct ZaberEmulator::Axis {
  Axis(const ZaberStage& stage, const Clock& clock)
      : steps_per_radian(static_cast<double>(stage.steps_per_turn) / (2 * kPi)),
        motor(stage.switched_on_at / steps_per_radian, kTop / steps_per_radian,
              kAcceleration / steps_per_radian, clock) {
    counter_zero = motor.Position();
  }

  long Counter() const { return std::lround((motor.Position() - counter_zero) * steps_per_radian); }
  std::string Flag() const {
    if (pressed) return "FH";
    if (disabled) return "FO";
    if (stalled) return "FS";
    if (!referenced && !Homing()) return "WR";
    return interrupted ? "NI" : "--";
  }
  bool Homing() const { return homing && motor.Moving(); }
  // A homing that has run to its end makes the mark the new zero.
  void Settle() {
    if (!homing || motor.Moving()) return;
    homing = false;
    referenced = true;
    counter_zero = 0;
  }
  void Halt() {
    interrupted = motor.Moving();
    homing = false;
    motor.Stop();
  }

  static constexpr double kTop = 400000;           // microsteps / s
  static constexpr double kAcceleration = 400000;  // microsteps / s^2
  const double steps_per_radian;
  SimMotor motor;           // its zero is the reference mark
  double counter_zero = 0;  // rad, where the controller counts from
  double speed = 200000;    // microsteps / s: maxspeed
  long accel_data = 655;
  bool referenced = false;
  bool homing = false;
  bool stalled = false;
  bool disabled = false;
  bool pressed = false;  // the emergency stop
  bool interrupted = false;
};

ZaberEmulator::ZaberEmulator(const ZaberStage& stage, std::shared_ptr<Clock> clock)
    : stage_(stage), clock_(std::move(clock)), axis_(std::make_unique<Axis>(stage, *clock_)) {}

ZaberEmulator::~ZaberEmulator() = default;

std::string ZaberEmulator::Receive(std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  std::string answers;
  for (const char c : bytes) {
    if (c != '\n' && c != '\r') {
      pending_ += c;
      continue;
    }
    answers += Answer(std::exchange(pending_, {}));
  }
  return answers;
}

// Commands it does not understand so far as to know who is meant are passed over in silence.
std::string ZaberEmulator::Answer(std::string line) {
  if (line.empty() || line[0] != '/') return {};
  if (const std::size_t colon = line.find(':'); colon != std::string::npos) {
    const long claimed = std::strtol(line.c_str() + colon + 1, nullptr, 16);
    if (claimed != Complement(std::string_view(line).substr(1, colon - 1))) return {};
    line.resize(colon);
  }
  int device = 0;
  int axis = 0;
  int id = -1;
  int used = 0;
  if (std::sscanf(line.c_str(), "/%d %d%n", &device, &axis, &used) < 2) return {};
  int more = 0;
  if (std::sscanf(line.c_str() + used, " %d%n", &id, &more) == 1) used += more;
  if (device != stage_.device || axis > 1) return {};
  const std::size_t data = line.find_first_not_of(' ', static_cast<std::size_t>(used));
  bool accepted = true;
  axis_->Settle();
  const std::string result =
      Do(data == std::string::npos ? "" : std::string_view(line).substr(data), &accepted);
  std::string reply = fmt::format("{:02d} {} ", device, axis);
  if (id >= 0) reply += fmt::format("{} ", id);
  reply += fmt::format("{} {} {} {}", accepted ? "OK" : "RJ",
                       axis_->motor.Moving() ? "BUSY" : "IDLE", axis_->Flag(), result);
  return fmt::format("@{}:{:02X}\r\n", reply, Complement(reply));
}

std::string ZaberEmulator::Do(std::string_view data, bool* accepted) {
  if (data.empty()) return "0";
  if (StartsWith(data, "get ")) return Get(data.substr(4), accepted);
  if (StartsWith(data, "set ")) return Set(data.substr(4), accepted);
  if (StartsWith(data, "move ")) return Move(data.substr(5), accepted);
  if (data == "driver enable" && axis_->pressed) {
    *accepted = false;
    return "DRIVERDISABLED";
  }
  if (data == "driver enable") {
    axis_->disabled = false;
    return "0";
  }
  if (data == "home" && axis_->disabled) {
    *accepted = false;
    return "DRIVERDISABLED";
  }
  if (data == "home") {
    axis_->Halt();
    axis_->stalled = axis_->interrupted = axis_->referenced = false;
    axis_->homing = true;
    axis_->motor.Start(0, 0.25);
    return "0";
  }
  if (data == "stop" || data == "estop") {
    axis_->Halt();
    return "0";
  }
  if (data == "warnings") {
    std::string flags;
    if (axis_->pressed) flags += " FH";
    if (axis_->disabled && !axis_->pressed) flags += " FO";
    if (axis_->stalled) flags += " FS";
    if (!axis_->referenced) flags += " WR";
    if (axis_->interrupted) flags += " NI";
    return fmt::format("{:02d}{}", flags.size() / 3, flags);
  }
  *accepted = false;
  return "BADCOMMAND";
}

std::string ZaberEmulator::Get(std::string_view setting, bool* accepted) const {
  if (setting == "pos") return std::to_string(axis_->Counter());
  if (setting == "limit.min") return std::to_string(stage_.least);
  if (setting == "limit.max") return std::to_string(stage_.most);
  if (setting == "limit.cycle.dist") return std::to_string(stage_.steps_per_turn);
  if (setting == "maxspeed") return std::to_string(std::lround(axis_->speed * 1.6384));
  if (setting == "accel") return std::to_string(axis_->accel_data);
  if (setting == "deviceid") return "50081";
  if (setting == "system.serial") return "67890";
  if (setting == "version") return "7.38";
  *accepted = false;
  return "BADCOMMAND";
}

std::string ZaberEmulator::Set(std::string_view rest, bool* accepted) {
  const std::string text(rest);
  const std::size_t space = text.find(' ');
  const long value = space == std::string::npos ? 0 : std::atol(text.c_str() + space);
  const std::string setting = text.substr(0, space);
  if (setting == "maxspeed" && value > 0 && static_cast<double>(value) / 1.6384 <= stage_.fastest) {
    axis_->speed = static_cast<double>(value) / 1.6384;
  } else if (setting == "accel" && value > 0) {
    axis_->accel_data = value;
  } else {
    *accepted = false;
    return "BADDATA";
  }
  return "0";
}

std::string ZaberEmulator::Move(std::string_view rest, bool* accepted) {
  long target = 0;
  if (std::sscanf(std::string(rest).c_str(), "abs %ld", &target) != 1 || target < stage_.least ||
      target > stage_.most) {
    *accepted = false;
    return "BADDATA";
  }
  if (axis_->disabled) {
    *accepted = false;
    return "DRIVERDISABLED";
  }
  axis_->Halt();
  axis_->stalled = axis_->interrupted = false;
  axis_->motor.Start(axis_->counter_zero + static_cast<double>(target) / axis_->steps_per_radian,
                     axis_->speed / Axis::kTop);
  return "0";
}

double ZaberEmulator::Shaft() const { return axis_->motor.Position(); }

void ZaberEmulator::Reset() {
  const std::lock_guard lock(mutex_);
  axis_->motor.Stop();
  axis_->homing = axis_->referenced = axis_->stalled = axis_->interrupted = false;
  axis_->counter_zero = axis_->motor.Position();
}

void ZaberEmulator::Stall() {
  const std::lock_guard lock(mutex_);
  axis_->Halt();
  axis_->stalled = true;
}

void ZaberEmulator::PressEmergencyStop() {
  CutMotorPower();
  const std::lock_guard lock(mutex_);
  axis_->pressed = true;
}

void ZaberEmulator::ReleaseEmergencyStop() {
  const std::lock_guard lock(mutex_);
  axis_->pressed = false;
}

void ZaberEmulator::CutMotorPower() {
  const std::lock_guard lock(mutex_);
  axis_->Halt();
  axis_->disabled = true;
}

}  // namespace gonio
