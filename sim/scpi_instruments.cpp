// SPDX-License-Identifier: Apache-2.0
#include "sim/scpi_instruments.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace gonio {
namespace {

constexpr std::size_t kMostErrors = 16;
constexpr int kUndefinedHeader = -113;
constexpr int kParameterOutOfRange = -222;
constexpr int kIllegalParameter = -224;

// A line up to its first blank, and what comes after.
std::pair<std::string, std::string> Split(std::string_view line) {
  const std::size_t blank = std::min(line.find(' '), line.size());
  return {std::string(line.substr(0, blank)),
          std::string(line.substr(std::min(blank + 1, line.size())))};
}

// The number that is all of `text`, or NaN.
double NumberOf(const std::string& text) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return text.empty() || *end != '\0' ? std::nan("") : number;
}

}  // namespace

void ScpiErrors::Note(int code, const std::string& text) {
  if (errors_.size() < kMostErrors) errors_.push_back(fmt::format("{},\"{}\"", code, text));
}

std::string ScpiErrors::Next() {
  if (errors_.empty()) return "+0,\"No error\"";
  std::string error = std::move(errors_.front());
  errors_.pop_front();
  return error;
}

std::string Dc2200Emulator::Receive(std::string_view line) {
  const std::lock_guard lock(mutex_);
  const auto [name, argument] = Split(line);
  return name.ends_with('?') ? Query(name) : Command(name, argument);
}

std::string Dc2200Emulator::Query(const std::string& name) {
  if (name == "*IDN?") return "Thorlabs,DC2200,M00310001,1.5.0";
  if (name == "SYST:ERR?") return errors_.Next();
  if (name == "SOURCE1:CURRENT:LIMIT?") return fmt::format("{:.6E}", limit_);
  if (name == "SOURCE1:CCURENT:CURRENT?") return fmt::format("{:.6E}", current_);
  if (name == "SOURCE1:MODE?") return mode_;
  if (name == "OUTPUT1:STATE?") return on_ ? "1" : "0";
  if (name == "SENSE3:CURRENT:DATA?") return fmt::format("{:.6E}", Flowing());
  errors_.Note(kUndefinedHeader, "Undefined header");
  return {};
}

std::string Dc2200Emulator::Command(const std::string& name, const std::string& argument) {
  if (name == "*CLS") {
    errors_.Clear();
  } else if (name == "SOURCE1:MODE") {
    constexpr std::array kModes = {"CC", "CB", "PWM", "TTL", "PULS"};
    if (std::find(kModes.begin(), kModes.end(), argument) == kModes.end()) {
      errors_.Note(kIllegalParameter, "Illegal parameter value");
    } else {
      mode_ = argument;
    }
  } else if (name == "SOURCE1:CCURENT:CURRENT") {
    const double current = NumberOf(argument);
    if (current >= 0 && current <= limit_) {
      current_ = current;
    } else {
      errors_.Note(kParameterOutOfRange, "Data out of range");
    }
  } else if (name == "OUTPUT1:STATE") {
    if (argument != "ON" && argument != "OFF") {
      errors_.Note(kIllegalParameter, "Illegal parameter value");
    } else {
      on_ = argument == "ON" && led_;
    }
  } else {
    errors_.Note(kUndefinedHeader, "Undefined header");
  }
  return {};
}

double Dc2200Emulator::Current() const {
  const std::lock_guard lock(mutex_);
  return Flowing();
}

void Dc2200Emulator::TurnByHand(double current) {
  const std::lock_guard lock(mutex_);
  current_ = current;
  on_ = current > 0;
}

void Dc2200Emulator::RemoveLed() {
  const std::lock_guard lock(mutex_);
  led_ = false;
}

PowerMeterEmulator::PowerMeterEmulator(std::function<double()> power)
    : PowerMeterEmulator(std::move(power), Settings()) {}
PowerMeterEmulator::PowerMeterEmulator(std::function<double()> power, Settings settings)
    : power_(std::move(power)), settings_(std::move(settings)) {}

std::string PowerMeterEmulator::Receive(std::string_view line) {
  const std::lock_guard lock(mutex_);
  const auto [name, argument] = Split(line);
  return name.ends_with('?') ? Query(name, argument) : Command(name, argument);
}

std::string PowerMeterEmulator::Query(const std::string& name, const std::string& argument) {
  if (name == "*IDN?") return settings_.identity;
  if (name == "SYST:ERR?") return errors_.Next();
  if (name == "SYST:SENS:IDN?") return settings_.sensor;
  if (name == "SENS:CORR:WAV?") {
    return fmt::format("{:.6E}", argument == "MIN" ? 400 : argument == "MAX" ? 1100 : wavelength_);
  }
  if (name == "SENS:AVER?") return fmt::format("{}", averaging_);
  if (name == "SENS:POW:RANG:AUTO?") return automatic_ ? "1" : "0";
  if (name == "SENS:POW:RANG?") return fmt::format("{:.6E}", range_);
  if (name == "SENS:POW:UNIT?") return watt_ ? "W" : "DBM";
  if (name == "FETC:STAT?" && settings_.says_when_ready) {
    return until_ready_-- > 0 ? "0" : "1";
  }
  if (name == "FETC?") return Fetch();
  errors_.Note(kUndefinedHeader, "Undefined header");
  return {};
}

std::string PowerMeterEmulator::Fetch() {
  if (!next_.empty()) return std::exchange(next_, {});
  if (!measures_power_) return "9.91E+37";
  if (!automatic_ && reading_ > range_) return "9.9E+37";
  if (watt_) return fmt::format("{:.8E}", reading_);
  return fmt::format("{:.8E}", 10 * std::log10(reading_ * 1e3));
}

std::string PowerMeterEmulator::Command(const std::string& name, const std::string& argument) {
  const double number = NumberOf(argument);
  bool sense = true;
  if (name == "*CLS") {
    errors_.Clear();
  } else if (name == "CONF:POW") {
    measures_power_ = true;
  } else if (name == "INIT") {
    reading_ = power_();
    until_ready_ = 3;
  } else if (name == "SENS:POW:UNIT") {
    sense = argument == "W" || argument == "DBM";
    if (sense) watt_ = argument == "W";
  } else if (name == "SENS:CORR:WAV") {
    sense = number >= 400 && number <= 1100;
    if (sense) wavelength_ = wavelength_step_ * std::round(number / wavelength_step_);
  } else if (name == "SENS:AVER") {
    sense = number >= 1 && number <= 10000;
    if (sense) averaging_ = static_cast<int>(number);
  } else if (name == "SENS:POW:RANG:AUTO") {
    sense = number == 0 || number == 1;
    if (sense) automatic_ = number == 1;
  } else if (name == "SENS:POW:RANG") {
    sense = number > 0;
    if (sense) {
      constexpr std::array kRanges = {5e-8, 5e-7, 5e-6, 5e-5, 5e-4, 5e-3, 5e-2};  // W
      const auto* const fits = std::find_if(kRanges.begin(), kRanges.end(),
                                            [&](double range) { return range >= number; });
      range_ = fits == kRanges.end() ? kRanges.back() : *fits;
      automatic_ = false;
    }
  } else {
    errors_.Note(kUndefinedHeader, "Undefined header");
  }
  if (!sense) errors_.Note(kParameterOutOfRange, "Data out of range");
  return {};
}

double PowerMeterEmulator::wavelength_nm() const {
  const std::lock_guard lock(mutex_);
  return wavelength_;
}
int PowerMeterEmulator::averaging() const {
  const std::lock_guard lock(mutex_);
  return averaging_;
}
bool PowerMeterEmulator::automatic() const {
  const std::lock_guard lock(mutex_);
  return automatic_;
}
double PowerMeterEmulator::range() const {
  const std::lock_guard lock(mutex_);
  return range_;
}
void PowerMeterEmulator::set_rounds_wavelength_to(double step_nm) {
  const std::lock_guard lock(mutex_);
  wavelength_step_ = step_nm;
}
void PowerMeterEmulator::ReadNext(const std::string& answer) {
  const std::lock_guard lock(mutex_);
  next_ = answer;
}

}  // namespace gonio
