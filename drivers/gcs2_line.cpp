// SPDX-License-Identifier: Apache-2.0
#include "drivers/gcs2_line.h"

#include <fmt/format.h>

#include <utility>

#include "drivers/asked_twice.h"
#include "drivers/awaited_line.h"
#include "drivers/deadline.h"
#include "drivers/gcs2_codec.h"
#include "drivers/wire_text.h"

namespace gonio::gcs2 {
namespace {

constexpr std::size_t kMostLines = 64;  // of a reply that we ask for
constexpr int kMostEmptyReplies = 3;    // to ERR?, which is then asked again

}  // namespace

Line::Line(std::unique_ptr<ByteLink> link, Seconds reply_limit)
    : link_(std::move(link)), lines_(link_.get()), reply_limit_(reply_limit) {}

Result<std::string> Line::Identity(int address) {
  auto identity = AskLine(address, "*IDN?", [](std::string_view line) -> Result<std::string> {
    if (IsIdentity(line)) return std::string(line);
    return Error{ErrorCode::kProtocol, Quoted(line) + " is no controller of Physik Instrumente"};
  });
  // Twice the same nonsense is another device.
  if (!identity && identity.error().code == ErrorCode::kProtocol) {
    return Error{ErrorCode::kRefused, identity.error().message};
  }
  return identity;
}

Result<double> Line::Syntax(int address) { return AskLine(address, "CSV?", SyntaxIn); }

Result<bool> Line::IsReady(int address) { return AskLine(address, kIsReady, ReadyIn); }

Result<unsigned> Line::Moving(int address) { return AskLine(address, kMotionStatus, MovingIn); }

Result<std::vector<std::string>> Line::Axes(int address) {
  return Ask(address, "SAI?", [](const std::vector<std::string>& lines) {
    std::vector<std::string> names;
    for (const std::string& line : lines) names.push_back(NameIn(line));
    return Result<std::vector<std::string>>(std::move(names));
  });
}

Result<std::string> Line::Unit(int address, const std::string& axis) {
  return AskLine(address, fmt::format("SPA? {} 0x07000601", axis), UnitIn);
}

Result<double> Line::Number(int address, const std::string& question, const std::string& axis) {
  return AskLine(address, fmt::format("{} {}", question, axis),
                 [&](std::string_view line) { return NumberOf(line, axis); });
}

Result<bool> Line::Flag(int address, const std::string& question, const std::string& axis) {
  return AskLine(address, fmt::format("{} {}", question, axis),
                 [&](std::string_view line) { return FlagOf(line, axis); });
}

template <typename Decode>
auto Line::Ask(int address, const std::string& question, Decode decode)
    -> decltype(decode(std::vector<std::string>())) {
  using Answer = decltype(decode(std::vector<std::string>()));
  const std::lock_guard lock(mutex_);
  return AskedTwice([&]() -> Answer {
    const bool was_in_step = in_step_;
    const Reply lines = Exchange(address, question);
    if (!lines && lines.error().code == ErrorCode::kTimeout && was_in_step) {
      // One that it does not like is passed over, too.
      const Result<int> why = TakeError(address);
      if (why && IsError(*why)) return Refused(address, question, *why);
    }
    if (!lines) return lines.error();
    Answer answer = decode(*lines);
    if (answer) return answer;
    in_step_ = false;
    return About(address, question, answer.error());
  });
}

template <typename Decode>
auto Line::AskLine(int address, const std::string& question, Decode decode)
    -> decltype(decode(std::string_view())) {
  using Answer = decltype(decode(std::string_view()));
  return Ask(address, question, [&](const std::vector<std::string>& lines) -> Answer {
    if (lines.size() == 1) return decode(lines.front());
    return Error{ErrorCode::kProtocol, fmt::format("{} lines, the first of them {}", lines.size(),
                                                   Quoted(lines.front()))};
  });
}

Result<void> Line::Command(int address, const std::string& command) {
  const std::lock_guard lock(mutex_);
  if (const auto before = TakeError(address); !before) return before.error();
  const auto sent = link_->Write(Encode(address, command), reply_limit_);
  if (!sent) return sent.error();
  const Result<int> error = TakeError(address);
  if (!error) return error.error();
  return IsError(*error) ? Refused(address, command, *error) : Result<void>();
}

Result<void> Line::Halt(int address, const std::string& axis) {
  const std::lock_guard lock(mutex_);
  const auto sent = link_->Write(Encode(address, fmt::format("HLT {}", axis)), reply_limit_);
  if (!sent) return sent.error();
  const Result<int> error = TakeError(address);
  if (!error) return error.error();
  return *error == kUnknownCommand ? SendStopAll(address) : Result<void>();
}

Result<void> Line::StopAll(int address) {
  const std::lock_guard lock(mutex_);
  return SendStopAll(address);
}

Result<void> Line::SendStopAll(int address) {
  const auto sent = link_->Write(Encode(address, kStopAll), reply_limit_);
  if (!sent) return sent.error();
  const Result<int> error = TakeError(address);
  return error ? Result<void>() : error.error();
}

Result<void> Line::ReadErrors(int address) {
  const std::lock_guard lock(mutex_);
  const Result<int> error = TakeError(address);
  return error ? Result<void>() : error.error();
}

// An error is gone once it has been sent, so this question is asked again only if the reply is
// empty, as it now and then is.
Result<int> Line::TakeError(int address) {
  std::string line;
  for (int replies = 0; replies < kMostEmptyReplies && line.empty(); ++replies) {
    const Reply reply = Exchange(address, "ERR?");
    if (!reply) return reply.error();
    line = NameIn(reply->front());
  }
  const Result<int> error = ErrorIn(line);
  if (!error) {
    in_step_ = false;
    return About(address, "ERR?", error.error());
  }
  if (IsFault(*error)) faults_.Note(address, TextOf(*error));
  return error;
}

int Line::faults() const {
  const std::lock_guard lock(mutex_);
  return faults_.pages();
}

std::string Line::FaultAfter(int faults, int address) const {
  const std::lock_guard lock(mutex_);
  return faults_.After(faults, address);
}

Line::Reply Line::Exchange(int address, const std::string& question) {
  if (!in_step_) {
    if (const auto stepped = GetInStep(address); !stepped) {
      return About(address, question, stepped.error());
    }
  }
  if (const auto discarded = lines_.Discard(); !discarded) return discarded.error();
  const auto sent = link_->Write(Encode(address, question), reply_limit_);
  if (!sent) return sent.error();
  Reply reply = ReadReply(address);
  if (reply) return reply;
  in_step_ = false;
  return About(address, question, reply.error());
}

Line::Reply Line::ReadReply(int address) {
  const Deadline deadline(reply_limit_);
  std::vector<std::string> lines;
  while (lines.size() < kMostLines) {
    const Result<std::string> line = lines_.Next(deadline.Left());
    if (!line) return line.error();
    const Result<std::string> text = FromController(address, *line);
    // A chain puts its address before the first line only.
    if (!text && lines.empty()) return text.error();
    lines.push_back(text ? *text : *line);
    if (IsLastLine(lines.back())) return lines;
  }
  return Error{ErrorCode::kProtocol, fmt::format("over {} lines", kMostLines)};
}

Result<void> Line::GetInStep(int address) {
  if (const auto discarded = lines_.Discard(); !discarded) return discarded.error();
  const auto sent = link_->Write(Encode(address, "*IDN?"), reply_limit_);
  if (!sent) return sent.error();
  const auto identity = AwaitedLine(lines_, reply_limit_, IsIdentity);
  if (!identity) return identity.error();
  in_step_ = true;
  return {};
}

Error Line::Refused(int address, const std::string& what, int error) const {
  return {ErrorCode::kRefused,
          fmt::format("{}: {}refused {}: {}", link_->name(),
                      address == 0 ? "" : fmt::format("controller {} ", address), Shown(what),
                      TextOf(error))};
}

Error Line::About(int address, const std::string& question, const Error& error) const {
  if (error.code == ErrorCode::kDisconnected) return error;
  const bool named = error.message.compare(0, link_->name().size(), link_->name()) == 0;
  return {
      error.code,
      fmt::format("{}{}{}, asked {}", named ? "" : link_->name() + ": ", error.message,
                  address == 0 ? "" : fmt::format(", controller {}", address), Shown(question))};
}

}  // namespace gonio::gcs2
