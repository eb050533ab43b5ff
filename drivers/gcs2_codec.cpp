// SPDX-License-Identifier: Apache-2.0
#include "drivers/gcs2_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <iterator>

#include "drivers/wire_text.h"

namespace gonio::gcs2 {
namespace {

constexpr int kStopped = 10;  // by HLT, STP or kStopAll
constexpr char kReady = '\xb1';
constexpr char kNotReady = '\xb0';

struct Named {
  int number;
  bool fault;
  const char* text;
};
constexpr Named kErrors[] = {
    {0, false, "no error"},
    {1, false, "syntax error"},
    {2, false, "unknown command"},
    {5, false, "not referenced, or servo off"},
    {7, false, "position out of limits"},
    {8, false, "velocity out of limits"},
    {10, false, "stopped"},
    {15, false, "no such axis"},
    {17, false, "parameter out of range"},
    {45, true, "referencing failed"},
    {49, true, "move to the limit switch failed"},
    {54, false, "unknown parameter"},
    {63, false, "still initialising"},
    {84, false, "motor is off"},
    {88, false, "not referenced"},
    {200, true, "no stage connected"},
    {214, true, "position cannot be calculated"},
    {215, true, "connection to the stage broken"},
    {216, true, "limit switch"},
    {333, true, "internal hardware error"},
    {602, true, "hardware voltage error"},
    {603, true, "hardware temperature out of range"},
    {-1024, true, "motion error: position error too large, servo off"},
};

const Named* Find(int error) {
  const auto* const known = std::find_if(std::begin(kErrors), std::end(kErrors),
                                         [&](const Named& e) { return e.number == error; });
  return known != std::end(kErrors) ? known : nullptr;
}

std::string_view Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

bool IsByte(std::string_view command) {
  return command.size() == 1 && command[0] > 0 && command[0] < ' ';
}

bool SameLetter(char any, char small) {
  return std::tolower(static_cast<unsigned char>(any)) == small;
}

template <typename Whole>
bool IsWhole(std::string_view text, int base, Whole* value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value, base);
  return error == std::errc() && end == text.data() + text.size();
}

Error Nonsense(std::string_view line, std::string_view question) {
  return {ErrorCode::kProtocol, fmt::format("{} does not answer {}", Quoted(line), question)};
}

}  // namespace

std::string Encode(int address, std::string_view command) {
  const char* const end = IsByte(command) ? "" : "\n";
  return address == 0 ? fmt::format("{}{}", command, end)
                      : fmt::format("{} {}{}", address, command, end);
}

std::string Shown(std::string_view command) {
  return IsByte(command) ? fmt::format("#{}", static_cast<int>(command[0])) : std::string(command);
}

bool IsLastLine(std::string_view line) { return line.empty() || line.back() != ' '; }

Result<std::string> FromController(int address, std::string_view line) {
  if (address == 0) return std::string(line);
  const std::string before = fmt::format("0 {} ", address);
  if (line.substr(0, before.size()) == before) return std::string(line.substr(before.size()));
  return Error{ErrorCode::kProtocol,
               fmt::format("{} is not from controller {}", Quoted(line), address)};
}

bool IsIdentity(std::string_view line) {
  constexpr std::string_view kMaker = "physik instrumente";
  return std::search(line.begin(), line.end(), kMaker.begin(), kMaker.end(), SameLetter) !=
         line.end();
}

Result<std::string> ValueOf(std::string_view line, std::string_view name) {
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos || Trimmed(line.substr(0, equals)) != name) {
    return Error{ErrorCode::kProtocol, fmt::format("{} is nothing of {}", Quoted(line), name)};
  }
  return std::string(Trimmed(line.substr(equals + 1)));
}

Result<double> NumberOf(std::string_view line, std::string_view name) {
  const Result<std::string> value = ValueOf(line, name);
  return value ? NumberIn(*value, name) : value.error();
}

Result<bool> FlagOf(std::string_view line, std::string_view name) {
  const Result<std::string> value = ValueOf(line, name);
  if (!value) return value.error();
  if (*value == "0" || *value == "1") return *value == "1";
  return Error{ErrorCode::kProtocol, fmt::format("{} is neither 0 nor 1", Quoted(line))};
}

std::string NameIn(std::string_view line) { return std::string(Trimmed(line)); }

Result<unsigned> MovingIn(std::string_view line) {
  unsigned axes = 0;
  if (IsWhole(Trimmed(line), 16, &axes)) return axes;
  return Nonsense(line, Shown(kMotionStatus));
}

Result<bool> ReadyIn(std::string_view line) {
  if (line.size() == 1 && (line[0] == kReady || line[0] == kNotReady)) return line[0] == kReady;
  return Nonsense(line, Shown(kIsReady));
}

Result<double> SyntaxIn(std::string_view line) { return NumberIn(Trimmed(line), "CSV?"); }

Result<std::string> UnitIn(std::string_view line) {
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos) return Nonsense(line, "SPA?");
  return std::string(Trimmed(line.substr(equals + 1)));
}

bool IsDegrees(std::string_view unit) {
  constexpr std::string_view kDegree = "deg";
  const std::string_view first = unit.substr(0, kDegree.size());
  return std::equal(first.begin(), first.end(), kDegree.begin(), kDegree.end(), SameLetter);
}

Result<int> ErrorIn(std::string_view line) {
  int error = 0;
  if (IsWhole(Trimmed(line), 10, &error)) return error;
  return Nonsense(line, "ERR?");
}

bool IsError(int error) { return error != 0 && error != kStopped; }

std::string TextOf(int error) {
  const Named* const known = Find(error);
  return known != nullptr ? known->text : fmt::format("error {}", error);
}

bool IsFault(int error) {
  const Named* const known = Find(error);
  return known == nullptr || known->fault;
}

}  // namespace gonio::gcs2
