// SPDX-License-Identifier: Apache-2.0
#include "sim/grbl_emulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/units.h"

namespace gonio {
namespace {

constexpr int kAxes = GrblBoard::kAxes;
constexpr double kOffset = 12.5;      // deg: of G54, in all axes
constexpr Seconds kBraking{0.1};      // until a cancelled jog is at rest
constexpr double kSlip = 0.7;         // deg: what a motor turns on that is stopped at once
constexpr std::size_t kBuffer = 128;  // bytes

std::string Triple(const std::array<double, kAxes>& a) {
  return fmt::format("{:.3f},{:.3f},{:.3f}", a[0], a[1], a[2]);
}

}  // namespace

// From rest to rest, all axes in proportion.
struct GrblEmulator::Path {
  Path(const Angles& begin, const Angles& end, double speed, double acceleration,
       const Clock& clock)
      : from(begin), to(end), along(0, speed, acceleration, clock) {
    double squares = 0;
    for (int i = 0; i < kAxes; ++i) squares += (to[i] - from[i]) * (to[i] - from[i]);
    length = std::sqrt(squares);
    along.Start(length);
  }

  Angles Now() const {
    Angles at = to;
    for (int i = 0; i < kAxes && length > 0; ++i) {
      at[i] = from[i] + (to[i] - from[i]) * along.Position() / length;
    }
    return at;
  }

  Angles from;
  Angles to;
  double length;
  SimMotor along;  // in degrees
};

GrblEmulator::GrblEmulator(const GrblBoard& board, std::shared_ptr<Clock> clock)
    : board_(board),
      clock_(std::move(clock)),
      rest_(board.switched_on_at_deg),
      counter_zero_(board.switched_on_at_deg) {
  settings_ = {{0, 10},   {1, 255},   {2, 0},     {3, 0},     {4, 0},      {5, 0},      {6, 0},
               {10, 1},   {11, 0.01}, {12, 2e-3}, {13, 0},    {20, 1},     {21, 1},     {22, 1},
               {23, 0},   {24, 120},  {25, 7200}, {26, 250},  {27, 1},     {30, 1e3},   {31, 0},
               {32, 0},   {100, 400}, {101, 400}, {102, 400}, {110, 2400}, {111, 3600}, {112, 1200},
               {120, 60}, {121, 80},  {122, 40},  {130, 270}, {131, 270},  {132, 270}};
  for (const auto& [number, value] : board.settings) settings_[number] = value;
}

GrblEmulator::~GrblEmulator() = default;

std::string GrblEmulator::Receive(std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  Advance();
  for (const char byte : bytes) Take(byte);
  return std::exchange(out_, {});
}

std::string GrblEmulator::Unasked() {
  const std::lock_guard lock(mutex_);
  Advance();
  return std::exchange(out_, {});
}

double GrblEmulator::Shaft(int axis) const {
  const std::lock_guard lock(mutex_);
  return RadFromDeg(Position()[static_cast<std::size_t>(axis)]);
}

int GrblEmulator::Heard(std::string_view part) const {
  const std::lock_guard lock(mutex_);
  int count = 0;
  for (std::size_t at = heard_.find(part); at != std::string::npos; ++count) {
    at = heard_.find(part, at + part.size());
  }
  return count;
}

GrblEmulator::Angles GrblEmulator::Position() const { return path_ ? path_->Now() : rest_; }

void GrblEmulator::Say(const std::string& line) { out_ += line + "\r\n"; }

void GrblEmulator::Take(char byte) {
  switch (byte) {
    case '?':
      asked_ = true;
      if (state_ != State::kHome && !blocked_) Report();
      return;
    case '!':
      if (state_ == State::kJog) CancelJog();
      if (state_ == State::kIdle) state_ = State::kHold;
      return;
    case '~':
      if (state_ == State::kHold) state_ = State::kIdle;
      return RunLines();
    case '\x18':
      return SoftReset();
    case '\x85':
      if (state_ == State::kJog) CancelJog();
      return;
    default:
      if (static_cast<unsigned char>(byte) < 0x80 && rx_.size() < kBuffer) rx_ += byte;
      if (byte == '\n' || byte == '\r') RunLines();
  }
}

// What has run its time.
void GrblEmulator::Advance() {
  while (path_ && !path_->along.Moving()) {
    rest_ = path_->to;
    path_.reset();
    if (queue_.empty()) break;
    const auto [to, feed] = queue_.front();
    queue_.pop_front();
    StartPath(to, feed);
  }
  if (braked_at_ && clock_->Now() - *braked_at_ >= kBraking) braked_at_.reset();
  if (path_ || braked_at_) return;
  if (state_ == State::kJog) state_ = State::kIdle;
  if (state_ != State::kHome) return;
  if (switches_lost_) {
    Say("ALARM:9");
    state_ = State::kAlarm;
    return SoftReset();
  }
  counter_zero_.fill(0);
  planned_ = rest_;
  at_switch_ = false;
  if (asked_) Report();
  state_ = State::kIdle;
  Say("ok");
  RunLines();
}

bool GrblEmulator::TakesLines() const {
  return !blocked_ && state_ != State::kHold && state_ != State::kHome && state_ != State::kSleep;
}

void GrblEmulator::RunLines() {
  while (TakesLines()) {
    const std::size_t end = rx_.find_first_of("\r\n");
    if (end == std::string::npos) return;
    std::string line;
    for (const char c : rx_.substr(0, end)) {
      if (c > ' ') line += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    }
    rx_.erase(0, end + 1);
    heard_ += line + '\n';
    const std::string before = std::exchange(out_, {});
    const int error = line.size() > 79 ? 11 : Obey(line);
    if (state_ != State::kHome) Say(error == 0 ? "ok" : fmt::format("error:{}", error));
    if (held_answers_ > 0) {
      --held_answers_;
      held_back_ += std::exchange(out_, before);
    } else {
      out_ = before + std::exchange(held_back_, {}) + out_;
    }
  }
}

int GrblEmulator::Obey(const std::string& line) {
  if (line.empty()) return 0;
  if (line[0] != '$') return state_ == State::kAlarm || state_ == State::kJog ? 9 : 20;
  if (line == "$") Say("[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]");
  if (line == "$G") Say("[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]");
  if (line == "$$") PrintSettings();
  if (line == "$" || line == "$G" || line == "$$") return 0;
  if (line == "$X") {
    if (state_ == State::kAlarm) Say("[MSG:Caution: Unlocked]");
    if (state_ == State::kAlarm) state_ = State::kIdle;
    return 0;
  }
  if (line == "$C") {
    if (state_ != State::kIdle) return 8;
    state_ = State::kCheck;
    Say("[MSG:Enabled]");
    return 0;
  }
  if (line[1] == 'J') {
    if (state_ != State::kIdle && state_ != State::kJog) return 8;
    return line.size() > 2 && line[2] == '=' ? Jog(line.substr(3)) : 3;
  }
  if (state_ != State::kIdle && state_ != State::kAlarm) return 8;
  if (line == "$I") {
    Say(fmt::format("[VER:{}]", board_.version));
    Say("[OPT:V,15,128]");
    return 0;
  }
  if (line == "$H") {
    if (settings_[22] == 0) return 5;
    StartHoming();
    return 0;
  }
  return Set(line);
}

int GrblEmulator::Jog(const std::string& words) {
  Angles target = planned_;
  bool machine = false;
  bool relative = false;
  double feed = 0;
  std::array<std::optional<double>, kAxes> given;
  for (const char* rest = words.c_str(); *rest != '\0';) {
    const char letter = *rest++;
    if (letter < 'A' || letter > 'Z') return 1;
    char* end = nullptr;
    const double number = std::strtod(rest, &end);
    if (end == rest) return 2;
    rest = end;
    if (letter == 'G') {
      if (number != 20 && number != 21 && number != 53 && number != 90 && number != 91) return 16;
      machine = machine || number == 53;
      relative = relative || number == 91;
    } else if (letter == 'F') {
      if (number < 0) return 4;
      feed = number;
    } else if (letter >= 'X') {
      given[static_cast<std::size_t>(letter - 'X')] = number;
    } else {
      return 20;
    }
  }
  if (feed == 0) return 22;
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (!given[i]) continue;
    target[i] = *given[i] + (machine ? 0 : relative ? planned_[i] : kOffset);
  }
  for (int i = 0; i < kAxes && settings_[20] != 0; ++i) {
    if (target[i] > 0 || target[i] < -settings_[130 + i]) return 15;
  }
  planned_ = target;
  if (path_) {
    queue_.emplace_back(target, feed);
  } else {
    StartPath(target, feed);
    state_ = State::kJog;
  }
  return 0;
}

// To there as the counter has it, no axis faster than it may be.
void GrblEmulator::StartPath(const Angles& to, double feed) {
  Angles end = to;
  double squares = 0;
  for (int i = 0; i < kAxes; ++i) {
    end[i] += counter_zero_[i];
    squares += (end[i] - rest_[i]) * (end[i] - rest_[i]);
  }
  double speed = feed / 60;
  double acceleration = 1e6;
  for (int i = 0; i < kAxes; ++i) {
    const double share = std::abs(end[i] - rest_[i]) / std::sqrt(squares);
    if (!(share > 0)) continue;
    speed = std::min(speed, settings_[110 + i] / 60 / share);
    acceleration = std::min(acceleration, settings_[120 + i] / share);
  }
  path_ = std::make_unique<Path>(rest_, end, speed, acceleration, *clock_);
}

void GrblEmulator::StartHoming() {
  state_ = State::kHome;
  asked_ = false;
  Angles switches;
  switches.fill(-settings_[27]);  // pulled off
  path_ = std::make_unique<Path>(rest_, switches, settings_[25] / 60, 1e3, *clock_);
}

void GrblEmulator::CancelJog() {
  rest_ = Position();
  path_.reset();
  queue_.clear();
  for (int i = 0; i < kAxes; ++i) planned_[i] = rest_[i] - counter_zero_[i];
  if (!braked_at_) braked_at_ = clock_->Now();
}

void GrblEmulator::Halt() {
  const bool moved = path_ != nullptr;
  CancelJog();
  braked_at_.reset();
  if (!moved) return;
  for (double& angle : rest_) angle -= kSlip;
  for (double& zero : counter_zero_) zero -= kSlip;  // the counter knows nothing of it
}

void GrblEmulator::SoftReset() {
  if (path_ || braked_at_) {
    Say(state_ == State::kHome ? "ALARM:6" : "ALARM:3");
    state_ = State::kAlarm;
  }
  Halt();
  if (state_ != State::kAlarm) state_ = state_ == State::kSleep ? State::kAlarm : State::kIdle;
  Welcome();
}

void GrblEmulator::Welcome() {
  blocked_ = asked_ = false;
  rx_.clear();
  reports_ = 0;
  Say("");
  Say("Grbl 1.1h ['$' for help]");
  if (state_ == State::kAlarm) Say("[MSG:'$H'|'$X' to unlock]");
}

void GrblEmulator::Report() {
  static constexpr const char* kNames[] = {"Idle",  "Hold:0", "Jog",  "Alarm",
                                           "Check", "Home",   "Sleep"};
  Angles at = Position();
  const bool work = settings_[10] == 0;
  for (int i = 0; i < kAxes; ++i) at[i] -= counter_zero_[i] + (work ? kOffset : 0);
  std::string report = fmt::format("<{}|{}Pos:{}|FS:0,0", kNames[static_cast<int>(state_)],
                                   work ? 'W' : 'M', Triple(at));
  if (at_switch_) report += "|Pn:X";
  if (reports_ % 10 == 0) report += fmt::format("|WCO:{}", Triple({kOffset, kOffset, kOffset}));
  if (reports_ % 10 == 1) report += "|Ov:100,100,100";
  ++reports_;
  asked_ = false;
  Say(report + '>');
}

void GrblEmulator::PrintSettings() {
  for (const auto& [number, value] : settings_) {
    const bool real = number >= 100 || number == 11 || number == 12 || number == 27;
    Say(fmt::format("${}={:.{}f}", number, value, real ? 3 : 0));
  }
}

int GrblEmulator::Set(const std::string& line) {
  char* end = nullptr;
  const long number = std::strtol(line.c_str() + 1, &end, 10);
  if (end == line.c_str() + 1 || *end != '=') return 3;
  const double value = std::strtod(end + 1, nullptr);
  if (value < 0) return 4;
  const auto setting = settings_.find(static_cast<int>(number));
  if (setting == settings_.end()) return 3;
  if (number == 20 && value != 0 && settings_[22] == 0) return 10;
  setting->second = value;
  return 0;
}

void GrblEmulator::Reset() {
  const std::lock_guard lock(mutex_);
  Halt();
  counter_zero_ = rest_;
  planned_.fill(0);
  state_ = settings_[22] != 0 ? State::kAlarm : State::kIdle;
  out_.clear();
  Welcome();
}

void GrblEmulator::CutMotorPower() {
  const std::lock_guard lock(mutex_);
  Halt();
  state_ = State::kSleep;
  Say("[MSG:Sleeping]");
}

void GrblEmulator::HitLimitSwitch() {
  const std::lock_guard lock(mutex_);
  Halt();
  state_ = State::kAlarm;
  blocked_ = at_switch_ = true;
  Say("ALARM:1");
  Say("[MSG:Reset to continue]");
}

void GrblEmulator::Press(char button) {
  const std::lock_guard lock(mutex_);
  Advance();
  Take(button);
}

void GrblEmulator::LoseSwitches() {
  const std::lock_guard lock(mutex_);
  switches_lost_ = true;
}

void GrblEmulator::HoldBack(int answers) {
  const std::lock_guard lock(mutex_);
  held_answers_ = answers;
}

}  // namespace gonio
