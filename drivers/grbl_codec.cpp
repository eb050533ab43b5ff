// SPDX-License-Identifier: Apache-2.0
#include "drivers/grbl_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

#include "core/check.h"
#include "drivers/wire_text.h"

namespace gonio::grbl {
namespace {

constexpr std::size_t kMostNumbers = 8;  // of a position: no relative of Grbl's has more axes
constexpr std::size_t kMostBytes = 79;   // of a line that it takes
constexpr double kMost = 1e6;            // of a target or feed, so that a line always fits

struct Text {
  int code;
  const char* text;
};

constexpr Text kErrors[] = {
    {1, "a word without its letter"},
    {2, "a number that is none"},
    {3, "it does not know this command"},
    {4, "a negative value"},
    {5, "homing is switched off ($22)"},
    {6, "step pulses too short"},
    {7, "its settings could not be read"},
    {8, "only while it is idle"},
    {9, "locked by an alarm or a jog"},
    {10, "soft limits need homing"},
    {11, "line too long"},
    {12, "too many steps per second"},
    {13, "the safety door is open"},
    {14, "text too long to be kept"},
    {15, "beyond the travel of the axis"},
    {16, "not a jog"},
    {17, "laser mode needs PWM"},
    {20, "unsupported G-code"},
    {21, "two commands of one group"},
    {22, "no feed rate"},
    {23, "not a whole number"},
    {33, "no valid target"},
};

constexpr Text kAlarms[] = {
    {1, "hard limit: a switch stopped it"},
    {2, "soft limit: a target beyond the travel"},
    {3, "reset while it moved"},
    {4, "probe in the wrong state"},
    {5, "probe found nothing"},
    {6, "homing was reset"},
    {7, "safety door opened while homing"},
    {8, "homing did not get off the limit switch"},
    {9, "homing did not find the limit switch"},
    {10, "homing did not find the second limit switch"},
};

constexpr std::string_view kStates[] = {"Idle", "Run",   "Hold", "Jog",  "Alarm",
                                        "Door", "Check", "Home", "Sleep"};

template <std::size_t size>
std::string Worded(const char* what, const Text (&texts)[size], int code) {
  const Text* const found = std::find_if(std::begin(texts), std::end(texts),
                                         [&](const Text& text) { return text.code == code; });
  std::string text = fmt::format("{} {}", what, code);
  return found == std::end(texts) ? text : fmt::format("{}, {}", text, found->text);
}

bool StartsWith(std::string_view text, std::string_view start) {
  return text.substr(0, start.size()) == start;
}

// Takes what stands before `separator` off the front of `rest`; all of it if there is none.
std::string_view Cut(std::string_view* rest, char separator) {
  const std::size_t end = std::min(rest->find(separator), rest->size());
  const std::string_view front = rest->substr(0, end);
  rest->remove_prefix(std::min(end + 1, rest->size()));
  return front;
}

// A code or a setting's number: no more than three digits.
std::optional<int> NumberOf(std::string_view digits) {
  int number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  const bool all = error == std::errc() && end == digits.data() + digits.size();
  return all && number >= 0 && number <= 999 ? std::optional(number) : std::nullopt;
}

Error Nonsense(std::string_view line) {
  return {ErrorCode::kProtocol, fmt::format("{} is not a line of Grbl's", Quoted(line))};
}

// Empty: not numbers, or too many.
std::vector<double> NumbersIn(std::string_view list) {
  std::vector<double> numbers;
  while (!list.empty()) {
    const Result<double> number = NumberIn(Cut(&list, ','), "a position");
    if (!number || numbers.size() == kMostNumbers) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

// "Hold:1"
bool DecodeState(std::string_view field, Report* report) {
  const std::string_view name = Cut(&field, ':');
  const auto* const state = std::find(std::begin(kStates), std::end(kStates), name);
  if (state == std::end(kStates)) return false;
  report->state = static_cast<State>(state - std::begin(kStates));
  const std::optional<int> detail = field.empty() ? 0 : NumberOf(field);
  report->detail = detail.value_or(0);
  return detail.has_value();
}

// What stands between the chevrons: fields in any order, of which only the state is always first.
bool DecodeReport(std::string_view fields, Report* report) {
  if (!DecodeState(Cut(&fields, '|'), report)) return false;
  while (!fields.empty()) {
    std::string_view value = Cut(&fields, '|');
    const std::string_view name = Cut(&value, ':');
    if (name == "MPos" || name == "WPos") {
      report->work = name == "WPos";
      report->position = NumbersIn(value);
    } else if (name == "WCO") {
      report->offset = NumbersIn(value);
      if (report->offset.empty()) return false;
    }
  }
  return !report->position.empty();
}

Result<Message> Coded(Kind kind, std::string_view line, std::size_t prefix) {
  const std::optional<int> code = NumberOf(line.substr(prefix));
  if (!code) return Nonsense(line);
  return Message{.kind = kind, .code = *code, .text = {}, .report = {}};
}

Message Said(Kind kind, std::string_view text) {
  return {.kind = kind, .code = 0, .text = std::string(text), .report = {}};
}

// "$110=500.000", or a start-up line, "$N0=G54".
Result<Message> DecodeSetting(std::string_view line) {
  std::string_view rest = line.substr(1);
  if (StartsWith(rest, "N")) return Said(Kind::kNote, line);
  const std::optional<int> number = NumberOf(Cut(&rest, '='));
  if (!number || rest.empty()) return Nonsense(line);
  return Message{.kind = Kind::kSetting, .code = *number, .text = std::string(rest), .report = {}};
}

}  // namespace

Result<Message> Decode(std::string_view line) {
  constexpr std::string_view kErrorPrefix = "error:";
  constexpr std::string_view kAlarmPrefix = "ALARM:";
  if (line == "ok") return Said(Kind::kOk, {});
  // An empty line comes before the welcome.
  if (line.empty() || line.front() == '>') return Said(Kind::kNote, line);
  if (StartsWith(line, kErrorPrefix)) return Coded(Kind::kError, line, kErrorPrefix.size());
  if (StartsWith(line, kAlarmPrefix)) return Coded(Kind::kAlarm, line, kAlarmPrefix.size());
  if (StartsWith(line, "Grbl")) {
    std::string_view words = line;
    Cut(&words, ' ');
    return Said(Kind::kWelcome, Cut(&words, ' '));
  }
  if (line.front() == '$') return DecodeSetting(line);
  const bool closed = line.size() >= 2;
  if (closed && line.front() == '[' && line.back() == ']') {
    return Said(Kind::kNote, line.substr(1, line.size() - 2));
  }
  Message message{.kind = Kind::kReport, .code = 0, .text = {}, .report = {}};
  if (closed && line.front() == '<' && line.back() == '>' &&
      DecodeReport(line.substr(1, line.size() - 2), &message.report)) {
    return message;
  }
  return Nonsense(line);
}

std::string Encode(const Leg& leg) {
  std::string line = "$J=G21G53";
  bool moves = false;
  for (std::size_t axis = 0; axis < leg.target.size(); ++axis) {
    if (!leg.target[axis]) continue;
    GONIO_CHECK(std::abs(*leg.target[axis]) < kMost, "a target is an angle");
    line += fmt::format("{}{:.4f}", kAxisLetters[axis], *leg.target[axis]);
    moves = true;
  }
  GONIO_CHECK(moves && leg.feed > 0 && leg.feed < kMost, "a leg leads somewhere at some speed");
  // Less than this would read as none.
  line += fmt::format("F{:.3f}", std::max(leg.feed, 1e-3));
  GONIO_CHECK(line.size() <= kMostBytes, "a jog fits into a line");
  return line;
}

std::string TextOfError(int code) { return Worded("error", kErrors, code); }
std::string TextOfAlarm(int code) { return Worded("alarm", kAlarms, code); }

std::string TextOf(State state) {
  switch (state) {
    case State::kIdle:
      return "idle";
    case State::kRun:
      return "running a program";
    case State::kHold:
      return "in a feed hold";
    case State::kJog:
      return "jogging";
    case State::kAlarm:
      return "locked by an alarm";
    case State::kDoor:
      return "waiting for its safety door";
    case State::kCheck:
      return "in check mode";
    case State::kHome:
      return "homing";
    case State::kSleep:
      return "asleep";
  }
  return "in an unknown state";
}

}  // namespace gonio::grbl
