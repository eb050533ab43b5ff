// SPDX-License-Identifier: Apache-2.0
#include "drivers/scpi.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "drivers/asked_twice.h"
#include "drivers/wire_text.h"

namespace gonio::scpi {
namespace {

constexpr const char* kWhoAreYou = "*IDN?";
constexpr const char* kNextError = "SYST:ERR?";
constexpr int kMostStale = 16;   // answers that are owed
constexpr int kMostErrors = 32;  // more than a queue of errors holds

std::string WithoutLineEnd(std::string answer) {
  answer.erase(answer.find_last_not_of("\r\n") + 1);
  return answer;
}

// Four fields, three commas.
bool IsIdentity(const std::string& answer) {
  return std::count(answer.begin(), answer.end(), ',') == 3;
}

// The code of `-113,"Undefined header"`.
Result<double> CodeOf(std::string_view error) {
  const std::string_view code = error.substr(0, error.find(','));
  return NumberIn(code.substr(!code.empty() && code.front() == '+' ? 1 : 0), kNextError);
}

}  // namespace

Result<std::unique_ptr<Instrument>> Instrument::Open(std::unique_ptr<MessageLink> link,
                                                     Seconds reply_limit) {
  std::unique_ptr<Instrument> instrument(new Instrument(std::move(link), reply_limit));
  const std::lock_guard lock(instrument->mutex_);
  if (const auto known = instrument->FallIn(); !known) return known.error();
  return instrument;
}

Result<void> Instrument::FallIn() {
  if (in_step_) return {};
  if (const auto cleared = link_->Clear(); !cleared) return cleared;
  const auto sent = link_->Write(fmt::format("{}\n", kWhoAreYou), reply_limit_);
  if (!sent) return sent;
  std::string answer;
  for (int i = 0; i < kMostStale; ++i) {
    const auto read = link_->Read(reply_limit_);
    if (!read) return OutOfStep(read.error(), kWhoAreYou);
    answer = WithoutLineEnd(*read);
    if (identity_.empty() && IsIdentity(answer)) identity_ = answer;
    if (answer == identity_ && !answer.empty()) {
      in_step_ = true;
      return {};
    }
  }
  return Error{ErrorCode::kProtocol,
               fmt::format("{}: {} does not say who it is", name(), Quoted(answer))};
}

Error Instrument::OutOfStep(const Error& error, const std::string& what) {
  in_step_ = false;
  const bool named = error.message.compare(0, name().size(), name()) == 0;
  return {error.code,
          fmt::format("{}{}, asked \"{}\"", named ? "" : name() + ": ", error.message, what)};
}

Result<std::string> Instrument::Exchange(const std::string& question, Seconds limit) {
  if (const auto known = FallIn(); !known) return known.error();
  const auto sent = link_->Write(question + "\n", limit);
  if (!sent) return OutOfStep(sent.error(), question);
  const auto answer = link_->Read(limit);
  if (!answer) return OutOfStep(answer.error(), question);
  return WithoutLineEnd(*answer);
}

Result<double> Instrument::NumberOf(const std::string& question, Seconds limit) {
  const auto answer = Exchange(question, limit);
  if (!answer) return answer.error();
  const std::string_view text(*answer);
  auto number = NumberIn(text.substr(text.substr(0, 1) == "+" ? 1 : 0), "the answer");
  if (!number) return OutOfStep(number.error(), question);
  return number;
}

Result<std::string> Instrument::Query(const std::string& question) {
  const std::lock_guard lock(mutex_);
  return AskedTwice([&] { return Exchange(question, reply_limit_); });
}

Result<double> Instrument::Number(const std::string& question) {
  const std::lock_guard lock(mutex_);
  return AskedTwice([&] { return NumberOf(question, reply_limit_); });
}

Result<double> Instrument::Number(const std::string& question, Seconds limit) {
  const std::lock_guard lock(mutex_);
  return NumberOf(question, limit);
}

// All that the device has noted, oldest first; empty: nothing went wrong.
Result<std::string> Instrument::Errors() {
  std::string all;
  for (int i = 0; i < kMostErrors; ++i) {
    const auto error = Exchange(kNextError, reply_limit_);
    if (!error) return error.error();
    const auto code = CodeOf(*error);
    if (!code) return OutOfStep(code.error(), kNextError);
    if (*code == 0) return all;
    all += (all.empty() ? "" : "; ") + *error;
  }
  return OutOfStep({ErrorCode::kProtocol, "errors without end"}, kNextError);
}

Result<void> Instrument::Command(const std::string& command) {
  const std::lock_guard lock(mutex_);
  // Errors left over from before must not be taken for this command's.
  if (const auto before = Errors(); !before) return before.error();
  const auto sent = link_->Write(command + "\n", reply_limit_);
  if (!sent) return OutOfStep(sent.error(), command);
  const auto errors = Errors();
  if (!errors) return errors.error();
  if (errors->empty()) return {};
  return Error{ErrorCode::kRefused,
               fmt::format("{}: refused \"{}\": {}", name(), command, *errors)};
}

}  // namespace gonio::scpi
