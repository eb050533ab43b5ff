// SPDX-License-Identifier: Apache-2.0
#include "drivers/smc100_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <optional>

#include "drivers/wire_text.h"

namespace gonio::smc100 {
namespace {

struct Bit {
  unsigned bit;
  const char* text;
};
constexpr Bit kErrors[] = {
    {0x001, "negative end of run"},  {0x002, "positive end of run"}, {0x004, "peak current"},
    {0x008, "RMS current"},          {0x010, "short circuit"},       {0x020, "following error"},
    {0x040, "homing time-out"},      {0x080, "wrong ESP stage"},     {0x100, "DC voltage too low"},
    {0x200, "80 W output exceeded"},
};

struct Letter {
  char letter;
  const char* text;
};
constexpr Letter kLetters[] = {
    {'A', "unknown message, or bad address"},
    {'B', "bad address"},
    {'C', "parameter missing or out of range"},
    {'D', "not allowed"},
    {'E', "home sequence already started"},
    {'F', "ESP stage unknown"},
    {'G', "displacement out of limits"},
    {'H', "not allowed while not referenced"},
    {'I', "not allowed in configuration"},
    {'J', "not allowed while disabled"},
    {'K', "not allowed while ready"},
    {'L', "not allowed while homing"},
    {'M', "not allowed while moving"},
    {'N', "position outside the soft limits"},
    {'S', "communication time-out"},
    {'U', "error of the EEPROM"},
    {'V', "error during execution"},
    {'W', "not for this controller"},
    {'X', "not for this controller"},
};

std::optional<unsigned> HexOf(std::string_view digits) {
  unsigned value = 0;
  const auto [end, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return value;
}

std::optional<State> StateOf(unsigned code) {
  if (code >= 0x0a && code <= 0x11) return State::kNotReferenced;
  switch (code) {
    case 0x14:
      return State::kConfiguration;
    case 0x1e:
    case 0x1f:
      return State::kHoming;
    case 0x28:
      return State::kMoving;
    case 0x32:
    case 0x33:
    case 0x34:
    case 0x35:
      return State::kReady;
    case 0x3c:
    case 0x3d:
    case 0x3e:
      return State::kDisabled;
    case 0x46:
    case 0x47:
      return State::kJogging;
    default:
      return std::nullopt;
  }
}

}  // namespace

std::string Encode(int address, std::string_view command) {
  return fmt::format("{}{}\r\n", address, command);
}

Result<std::string> AnswerTo(int address, std::string_view command, std::string_view line) {
  const std::string expected = fmt::format("{}{}", address, command);
  if (line.substr(0, expected.size()) != expected) {
    return Error{ErrorCode::kProtocol,
                 fmt::format("{} does not answer {}", Quoted(line), expected)};
  }
  return std::string(line.substr(expected.size()));
}

Result<Status> DecodeStatus(std::string_view answer) {
  const auto errors = answer.size() == 6 ? HexOf(answer.substr(0, 4)) : std::nullopt;
  const auto code = answer.size() == 6 ? HexOf(answer.substr(4)) : std::nullopt;
  const auto state = code ? StateOf(*code) : std::nullopt;
  if (!errors || !state) {
    return Error{ErrorCode::kProtocol, fmt::format("{} is no status", Quoted(answer))};
  }
  return Status{*errors, *state};
}

std::string TextOf(unsigned errors) {
  std::string text;
  for (const Bit& error : kErrors) {
    if ((errors & error.bit) == 0) continue;
    if (!text.empty()) text += ", ";
    text += error.text;
    errors &= ~error.bit;
  }
  if (errors != 0) text += fmt::format("{}error {:04X}", text.empty() ? "" : ", ", errors);
  return text;
}

std::string TextOfCommandError(char letter) {
  if (letter == '@') return {};
  const auto* const known = std::find_if(std::begin(kLetters), std::end(kLetters),
                                         [&](const Letter& l) { return l.letter == letter; });
  return known != std::end(kLetters) ? known->text
                                     : "error " + Quoted(std::string_view(&letter, 1));
}

}  // namespace gonio::smc100
