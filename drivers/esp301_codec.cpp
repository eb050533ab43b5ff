// SPDX-License-Identifier: Apache-2.0
#include "drivers/esp301_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>

#include "drivers/wire_text.h"

namespace gonio::esp301 {
namespace {

struct Named {
  int number;
  bool fault;
  const char* text;
};
constexpr Named kOfController[] = {
    {1, false, "communication time-out"},
    {2, false, "communication time-out"},
    {4, true, kEmergencyStop},
    {6, false, "command does not exist"},
    {7, false, "parameter out of range"},
    {8, true, "cable interlock"},
    {9, false, "axis number out of range"},
    {23, true, "servo cycle failed"},
    {25, false, "download in progress"},
    {27, false, "command not allowed"},
    {37, false, "axis number missing"},
    {38, false, "command parameter missing"},
};
constexpr Named kOfAxis[] = {
    {0, false, "motor type not defined"},
    {1, false, "parameter out of range"},
    {2, true, "amplifier fault"},
    {3, true, "following error"},
    {4, true, "positive hardware limit"},
    {5, true, "negative hardware limit"},
    {6, false, "positive software limit"},
    {7, false, "negative software limit"},
    {8, true, "motor or stage not connected"},
    {9, true, "feedback signal fault"},
    {10, false, "maximum velocity exceeded"},
    {11, false, "maximum acceleration exceeded"},
    {13, false, "motor not enabled"},
    {15, false, "maximum jerk exceeded"},
    {20, true, "homing aborted"},
    {22, true, "motor driver does not answer"},
    {24, false, "speed out of range"},
    {27, false, "trajectory mode does not allow homing"},
    {29, true, "interlock"},
    {30, false, "command not allowed during homing"},
    {32, false, "trajectory mode does not allow moving"},
};

constexpr const char* kUnits[] = {
    "encoder counts", "motor steps", "mm",   "um",  "inches", "milli-inches",
    "micro-inches",   "degrees",     "grad", "rad", "mrad",   "urad",
};

const Named* Find(const QueuedError& error) {
  const auto among = [&](const auto& table) -> const Named* {
    const auto* const known = std::find_if(std::begin(table), std::end(table), [&](const Named& n) {
      return n.number == error.number;
    });
    return known != std::end(table) ? known : nullptr;
  };
  return error.axis == 0 ? among(kOfController) : among(kOfAxis);
}

std::string_view Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

// A whole number of at most `most`.
Result<int> CountIn(std::string_view answer, int most, std::string_view what) {
  const std::string_view text = Trimmed(answer);
  int count = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error != std::errc() || end != text.data() + text.size() || count < 0 || count > most) {
    return Error{ErrorCode::kProtocol, fmt::format("{} does not answer {}", Quoted(answer), what)};
  }
  return count;
}

}  // namespace

std::string Encode(int axis, std::string_view command) {
  return axis == 0 ? fmt::format("{}\r", command) : fmt::format("{}{}\r", axis, command);
}

bool IsUnasked(std::string_view line) {
  return line.size() > 1 && line[0] == 'E' && line[1] >= '0' && line[1] <= '9';
}

bool IsVersion(std::string_view line) { return Trimmed(line).substr(0, 5) == "ESP30"; }

Result<bool> FlagIn(std::string_view answer, std::string_view what) {
  const Result<int> count = CountIn(answer, 1, what);
  if (!count) return count.error();
  return *count == 1;
}

Result<double> ValueIn(std::string_view answer, std::string_view what) {
  return NumberIn(Trimmed(answer), what);
}

Result<int> UnitIn(std::string_view answer) {
  return CountIn(answer, static_cast<int>(std::size(kUnits)) - 1, "SN?");
}

std::string TextOfUnit(int unit) {
  const bool known = unit >= 0 && unit < static_cast<int>(std::size(kUnits));
  return known ? kUnits[unit] : fmt::format("unit {}", unit);
}

Result<QueuedError> ErrorIn(std::string_view answer) {
  const Result<int> code = CountIn(answer, 9999, "TE?");
  if (!code) return code.error();
  return QueuedError{*code / 100, *code % 100};
}

std::string TextOf(const QueuedError& error) {
  const Named* const known = Find(error);
  return known != nullptr ? known->text : fmt::format("error {}", 100 * error.axis + error.number);
}

bool IsFault(const QueuedError& error) {
  const Named* const known = Find(error);
  return known == nullptr || known->fault;
}

}  // namespace gonio::esp301
