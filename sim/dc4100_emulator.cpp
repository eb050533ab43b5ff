// SPDX-License-Identifier: Apache-2.0
#include "sim/dc4100_emulator.h"

#include <fmt/format.h>

#include <sstream>
#include <utility>

namespace gonio {
namespace {

constexpr const char* kNoError = "ERROR 0:No error";

}  // namespace

std::string Dc4100Emulator::Receive(std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  std::string answers;
  for (const char c : bytes) {
    if (c == '\r') continue;
    if (c != '\n') {
      pending_ += c;
      continue;
    }
    const std::string answer = Obey(std::exchange(pending_, {}));
    if (!answer.empty()) answers += answer + "\r\n";
  }
  return answers;
}

void Dc4100Emulator::Fail(int code, const char* text) {
  error_ = fmt::format("ERROR {}:{}", code, text);
}

std::string Dc4100Emulator::Obey(const std::string& line) {
  std::istringstream words(line);
  std::string name;
  std::string first;
  std::string second;
  words >> name >> first >> second;
  if (name == "e?") return std::exchange(error_, kNoError);
  if (name == "n?") return "DC4100";
  if (name == "s?") return "M00226347";
  if (name == "v?") return "1.4.0";
  if (name == "m?") return fmt::format("{}", mode_);
  if (name == "m") {
    if (first.size() == 1 && first >= "0" && first <= "2") {
      mode_ = first[0] - '0';
    } else {
      Fail(2, "Parameter out of range");
    }
    return {};
  }
  const bool all = name == "o" && first == "-1";
  const bool one = first.size() == 1 && first >= "0" && first < std::to_string(kChannels);
  if (!all && !one) {
    Fail(1, "Command not defined");
    return {};
  }
  if (name.ends_with('?')) return Answer(name, first[0] - '0');
  for (int channel = 0; channel < kChannels; ++channel) {
    if (all || channel == first[0] - '0') Set(name, channel, second);
  }
  return {};
}

std::string Dc4100Emulator::Answer(const std::string& question, int index) {
  const Channel& channel = channels_[static_cast<std::size_t>(index)];
  if (question == "o?") return channel.on ? "1" : "0";
  if (question == "cc?") return fmt::format("{}", channel.milliamperes);
  if (question == "l?") return fmt::format("{}", channel.user_limit);
  if (question == "ml?") return fmt::format("{}", channel.most);
  if (question == "wl?") return fmt::format("{}", 470 + 60 * index);
  if (question == "fb?") return "25";
  if (question == "hs?") return fmt::format("M0020000{}", index);
  Fail(1, "Command not defined");
  return {};
}

void Dc4100Emulator::Set(const std::string& name, int index, const std::string& argument) {
  Channel& channel = channels_[static_cast<std::size_t>(index)];
  std::istringstream text(argument);
  int number = -1;
  text >> number;
  const bool whole = !text.fail() && text.eof();
  if (name == "o" && whole && (number == 0 || number == 1)) {
    if (!channel.stuck) channel.on = number == 1;
  } else if (name == "cc" && mode_ != 0) {
    Fail(3, "Not in this mode");
  } else if (name == "cc" && whole && number >= 0 && number <= channel.user_limit) {
    channel.milliamperes = number;
  } else if (name == "o" || name == "cc") {
    Fail(2, "Parameter out of range");
  } else {
    Fail(1, "Command not defined");
  }
}

double Dc4100Emulator::Current(int channel) const {
  const std::lock_guard lock(mutex_);
  const Channel& led = channels_[static_cast<std::size_t>(channel)];
  return led.on ? 1e-3 * led.milliamperes : 0;
}

void Dc4100Emulator::set_stuck(int channel) {
  const std::lock_guard lock(mutex_);
  channels_[static_cast<std::size_t>(channel)].stuck = true;
}

void Dc4100Emulator::TurnByHand(int channel, int milliamperes) {
  const std::lock_guard lock(mutex_);
  channels_[static_cast<std::size_t>(channel)].milliamperes = milliamperes;
  channels_[static_cast<std::size_t>(channel)].on = milliamperes > 0;
}

}  // namespace gonio
