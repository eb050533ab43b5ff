// SPDX-License-Identifier: Apache-2.0
#include "drivers/usbtmc_codec.h"

#include <fmt/format.h>

#include <utility>

#include "drivers/wire_text.h"

namespace gonio::usbtmc {
namespace {

constexpr std::uint8_t kMessageOut = 1;
constexpr std::uint8_t kMessageIn = 2;  // the request and its answer
constexpr std::uint8_t kEndOfMessage = 0x01;
constexpr std::size_t kAlignment = 4;
constexpr std::size_t kCapabilityBytes = 24;

std::uint8_t ByteOf(std::string_view bytes, std::size_t at) {
  return static_cast<std::uint8_t>(bytes[at]);
}

std::string Header(std::uint8_t message, std::uint8_t tag, std::uint32_t bytes,
                   std::uint8_t attributes) {
  std::string header(kHeaderBytes, '\0');
  header[0] = static_cast<char>(message);
  header[1] = static_cast<char>(tag);
  header[2] = static_cast<char>(~tag);
  for (int i = 0; i < 4; ++i) header[4 + i] = static_cast<char>(bytes >> (8 * i) & 0xff);
  header[8] = static_cast<char>(attributes);
  return header;
}

Error Nonsense(std::string message) { return {ErrorCode::kProtocol, std::move(message)}; }

}  // namespace

std::uint8_t NextTag(std::uint8_t tag) { return tag == 255 ? 1 : tag + 1; }

std::string EncodeOut(std::uint8_t tag, std::string_view payload, bool end_of_message) {
  std::string transfer = Header(kMessageOut, tag, static_cast<std::uint32_t>(payload.size()),
                                end_of_message ? kEndOfMessage : 0);
  transfer += payload;
  transfer.resize((transfer.size() + kAlignment - 1) / kAlignment * kAlignment, '\0');
  return transfer;
}

std::string EncodeRequestIn(std::uint8_t tag, std::uint32_t most_bytes) {
  return Header(kMessageIn, tag, most_bytes, 0);
}

Result<InHeader> DecodeIn(std::string_view transfer, std::uint8_t tag, std::size_t most_bytes) {
  if (transfer.size() < kHeaderBytes) {
    return Nonsense(fmt::format("{} is no header of a transfer", Quoted(transfer)));
  }
  if (ByteOf(transfer, 0) != kMessageIn) {
    return Nonsense(fmt::format("a transfer of kind {} came, not an answer", ByteOf(transfer, 0)));
  }
  const std::uint8_t got = ByteOf(transfer, 1);
  if (static_cast<std::uint8_t>(~got) != ByteOf(transfer, 2)) {
    return Nonsense(fmt::format("the number of a transfer, {}, is garbled", got));
  }
  if (got != tag) return Nonsense(fmt::format("transfer {} was answered instead of {}", got, tag));
  InHeader header;
  for (int i = 0; i < 4; ++i) header.bytes |= std::size_t{ByteOf(transfer, 4 + i)} << (8 * i);
  if (header.bytes > most_bytes) {
    return Nonsense(fmt::format("a transfer of {} bytes was announced, {} were asked for",
                                header.bytes, most_bytes));
  }
  header.end_of_message = (ByteOf(transfer, 8) & kEndOfMessage) != 0;
  return header;
}

Result<Capabilities> DecodeCapabilities(std::string_view reply) {
  const auto answered = DecodeStatus(Request::kGetCapabilities, reply);
  if (!answered) return answered.error();
  if (answered->status != Status::kSuccess || reply.size() < kCapabilityBytes) {
    return Nonsense(fmt::format("{} are no capabilities", Quoted(reply)));
  }
  const auto bit = [&](std::size_t byte, int number) {
    return (ByteOf(reply, byte) >> number & 1) != 0;
  };
  return Capabilities{.listen_only = bit(4, 0),
                      .talk_only = bit(4, 1),
                      .indicator_pulse = bit(4, 2),
                      .ends_on_character = bit(5, 0),
                      .trigger = bit(14, 0),
                      .remote_local = bit(14, 1),
                      .is_488_2 = bit(14, 2),
                      .service_request = bit(15, 2),
                      .scpi = bit(15, 3)};
}

Result<StatusReply> DecodeStatus(Request request, std::string_view reply) {
  const std::size_t least = request == Request::kInitiateClear ? 1 : 2;
  if (reply.size() < least) return Nonsense(fmt::format("{} is no status", Quoted(reply)));
  switch (const auto status = static_cast<Status>(ByteOf(reply, 0))) {
    case Status::kSuccess:
    case Status::kPending:
    case Status::kFailed:
    case Status::kTransferNotInProgress:
    case Status::kSplitNotInProgress:
    case Status::kSplitInProgress: {
      const bool check =
          request == Request::kCheckAbortBulkInStatus || request == Request::kCheckClearStatus;
      return StatusReply{status, check && (ByteOf(reply, 1) & 1) != 0};
    }
  }
  return Nonsense(fmt::format("{} is no status", Quoted(reply)));
}

const char* TextOf(Status status) {
  switch (status) {
    case Status::kSuccess:
      return "success";
    case Status::kPending:
      return "pending";
    case Status::kFailed:
      return "failed";
    case Status::kTransferNotInProgress:
      return "transfer not in progress";
    case Status::kSplitNotInProgress:
      return "split transaction not in progress";
    case Status::kSplitInProgress:
      return "split transaction in progress";
  }
  return "unknown status";
}

}  // namespace gonio::usbtmc
