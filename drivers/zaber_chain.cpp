// SPDX-License-Identifier: Apache-2.0
#include "drivers/zaber_chain.h"

#include <fmt/format.h>

#include <utility>

#include "drivers/asked_twice.h"
#include "drivers/deadline.h"

namespace gonio::zaber {
namespace {

constexpr int kIds = 255;  // 1 .. 255: 0 is what devices answer that know no ids

}  // namespace

Chain::Chain(std::unique_ptr<ByteLink> link, Seconds reply_limit)
    : link_(std::move(link)), lines_(link_.get()), reply_limit_(reply_limit) {}

Result<Message> Chain::Query(int device, int axis, const std::string& data) {
  return AskedTwice([&] { return Command(device, axis, data); });
}

Result<Message> Chain::Command(int device, int axis, const std::string& data) {
  const std::lock_guard lock(mutex_);
  Result<Message> reply = Exchange(device, axis, data);
  if (!reply) return About(device, axis, data, reply.error());
  if (!reply->accepted) {
    return Error{ErrorCode::kRefused, fmt::format("{}: device {} axis {} rejected \"{}\": {}",
                                                  name(), device, axis, data, reply->data)};
  }
  return reply;
}

Result<Message> Chain::Exchange(int device, int axis, const std::string& data) {
  last_id_ = last_id_ % kIds + 1;
  const std::string command =
      Encode({.device = device, .axis = axis, .id = last_id_, .data = data});
  // What is still there belongs to questions that were given up.
  if (const Result<void> discarded = lines_.Discard(); !discarded) return discarded.error();
  const Deadline deadline(reply_limit_);
  if (const auto sent = link_->Write(command, reply_limit_); !sent) return sent.error();
  while (true) {
    const Result<std::string> line = lines_.Next(deadline.Left());
    if (!line && line.error().code == ErrorCode::kTimeout) {
      return Error{ErrorCode::kTimeout,
                   fmt::format("{}: no answer within {:.3g} s", name(), reply_limit_.count())};
    }
    if (!line) return line.error();
    const Result<Message> message = Decode(*line);
    if (!message) return message.error();
    if (message->kind == Kind::kReply && message->id == last_id_ && message->device == device &&
        message->axis == axis) {
      return message;
    }
  }
}

Error Chain::About(int device, int axis, const std::string& data, const Error& error) const {
  const bool named = error.message.compare(0, name().size(), name()) == 0;
  return {error.code, fmt::format("{}{}, device {} axis {}, asked \"{}\"",
                                  named ? "" : name() + ": ", error.message, device, axis, data)};
}

}  // namespace gonio::zaber
