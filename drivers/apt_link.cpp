// SPDX-License-Identifier: Apache-2.0
#include "drivers/apt_link.h"

#include <fmt/format.h>

#include <utility>

#include "drivers/asked_twice.h"
#include "drivers/deadline.h"

namespace gonio::apt {
namespace {

constexpr std::size_t kChunk = 4096;
constexpr std::size_t kMostBacklog = 1 << 16;  // unread; an hour of chatter is forgotten, not kept
constexpr Seconds kQuiet{0.02};                // longer than USB adapters hold bytes back

// What may come at any time.
bool IsUnasked(std::uint16_t id) {
  return id == kMoveHomed || id == kMoveCompleted || id == kMoveStopped || id == kGetStatusUpdate ||
         id == kGetDcStatusUpdate || id == kGetStatusBits;
}

Error Refused(const Report& report) { return {ErrorCode::kRefused, "refused with " + report.text}; }

}  // namespace

Link::Link(std::unique_ptr<ByteLink> link, Seconds reply_limit)
    : link_(std::move(link)), reply_limit_(reply_limit) {}

Result<Message> Link::Query(const Message& question, Id answer) {
  const std::lock_guard lock(mutex_);
  Result<Message> got = AskedTwice([&] { return Exchange(nullptr, question, answer); });
  return got ? got : About(question, got.error());
}

Result<void> Link::Command(const Message& command, const Address& motor) {
  const std::lock_guard lock(mutex_);
  const auto read = Exchange(&command, AboutMotor(kReqStatusBits, motor), kGetStatusBits);
  return read ? Result<void>() : About(command, read.error());
}

Result<void> Link::Tell(const Message& message) {
  const std::lock_guard lock(mutex_);
  return link_->Write(Encode(message), reply_limit_);
}

std::string Link::ReportOf(int module) {
  const std::lock_guard lock(mutex_);
  const auto report = reports_.find(module);
  return report == reports_.end() ? std::string() : report->second;
}

bool Link::HasHomed(const Address& motor) {
  const std::lock_guard lock(mutex_);
  return homed_.contains({motor.module, motor.channel});
}

void Link::Forget(int module) {
  const std::lock_guard lock(mutex_);
  reports_.erase(module);
  std::erase_if(homed_, [&](const auto& motor) { return motor.first == module; });
}

Result<Message> Link::Exchange(const Message* command, const Message& question, Id answer) {
  if (const Result<void> ready = CatchUp(); !ready) return ready.error();
  const Deadline deadline(reply_limit_);
  const std::string bytes = (command ? Encode(*command) : std::string()) + Encode(question);
  if (const auto sent = link_->Write(bytes, reply_limit_); !sent) return sent.error();
  std::optional<Error> refusal;
  std::string strange;
  while (true) {
    Result<Message> message = Next(deadline.Left());
    if (!message && message.error().code == ErrorCode::kTimeout && !strange.empty()) {
      return Error{ErrorCode::kProtocol, fmt::format("{} came instead of an answer", strange)};
    }
    if (!message) return message;
    const bool ours = message->source == question.dest;
    if (const auto report = ReportIn(*message); report && ours) {
      if (report->about == question.id) return Refused(*report);
      if (command && (report->about == command->id || report->about == 0)) {
        refusal = Refused(*report);
        continue;
      }
    }
    if (ours && message->id == answer && ChannelOf(*message) == ChannelOf(question)) {
      return refusal ? Result<Message>(*refusal) : message;
    }
    if (!ReportIn(*message) && !IsUnasked(message->id)) strange = NameOf(message->id);
    Note(*message);
  }
}

Result<Message> Link::Next(Seconds left) {
  const Deadline deadline(left);
  while (true) {
    Result<std::optional<Message>> message = TakeMessage(&pending_);
    if (!message) {
      Resynchronise();
      return message.error();
    }
    if (*message) return std::move(**message);
    const bool late = deadline.Left() <= Seconds(0);
    const Result<std::string> more =
        late ? Error{ErrorCode::kTimeout, ""} : link_->Read(kChunk, deadline.Left());
    if (more) {
      pending_ += *more;
    } else if (more.error().code != ErrorCode::kTimeout) {
      return more.error();
    } else if (!pending_.empty()) {
      Resynchronise();
      return Error{ErrorCode::kProtocol, "a message that broke off"};
    } else {
      return Error{ErrorCode::kTimeout,
                   fmt::format("no answer within {:.3g} s", reply_limit_.count())};
    }
  }
}

Result<void> Link::CatchUp() {
  while (pending_.size() < kMostBacklog) {
    const Result<std::string> more = link_->Read(kChunk, Seconds(0));
    if (!more && more.error().code != ErrorCode::kTimeout) return more.error();
    if (!more) break;
    pending_ += *more;
  }
  while (true) {
    const Result<std::optional<Message>> message = TakeMessage(&pending_);
    if (!message) {
      Resynchronise();
      return {};
    }
    if (!*message) return {};
    Note(**message);
  }
}

void Link::Note(const Message& message) {
  if (const auto report = ReportIn(message)) {
    reports_[message.source] = fmt::format("its controller reports {}", report->text);
  }
  if (message.id == kMoveHomed) homed_.insert({message.source, ChannelOf(message).value_or(1)});
}

// That the link is gone shows when it is used next.
void Link::Resynchronise() {
  pending_.clear();
  const Deadline deadline(reply_limit_);
  while (deadline.Left() > Seconds(0) && link_->Read(kChunk, kQuiet)) {
  }
  (void)link_->DiscardInput();
}

Error Link::About(const Message& message, const Error& error) const {
  const std::string& name = link_->name();
  const bool named = error.message.compare(0, name.size(), name) == 0;
  return {error.code, fmt::format("{}{}, module 0x{:02x}, told {}", named ? "" : name + ": ",
                                  error.message, message.dest, NameOf(message.id))};
}

}  // namespace gonio::apt
