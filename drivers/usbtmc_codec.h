// SPDX-License-Identifier: Apache-2.0
// The USB test and measurement class (USBTMC 1.0 and its USB488 part), as bytes.

#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/error.h"

namespace gonio::usbtmc {

inline constexpr std::size_t kHeaderBytes = 12;

// 1 .. 255 and again: the number of a transfer, which its answer repeats.
std::uint8_t NextTag(std::uint8_t tag);

// A transfer to the device that holds `payload`, padded to a multiple of four bytes.
// `end_of_message`: nothing of the message comes after it.
std::string EncodeOut(std::uint8_t tag, std::string_view payload, bool end_of_message);

// Asks for at most so many bytes of the device's answer.
std::string EncodeRequestIn(std::uint8_t tag, std::uint32_t most_bytes);

// What the first bytes of a transfer from the device say of it.
struct InHeader {
  std::size_t bytes = 0;  // of payload in this transfer; what follows them is padding
  bool end_of_message = false;
};
// The header at the front of `transfer`, which must answer the request of this tag and size.
// kProtocol: it does not.
Result<InHeader> DecodeIn(std::string_view transfer, std::uint8_t tag, std::size_t most_bytes);

// Requests to the control endpoint.
enum class Request : std::uint8_t {
  kInitiateAbortBulkOut = 1,
  kCheckAbortBulkOutStatus = 2,
  kInitiateAbortBulkIn = 3,
  kCheckAbortBulkInStatus = 4,
  kInitiateClear = 5,
  kCheckClearStatus = 6,
  kGetCapabilities = 7,
};

struct Capabilities {
  bool listen_only = false;
  bool talk_only = false;
  bool indicator_pulse = false;
  bool ends_on_character = false;  // can end an answer at a given byte
  bool trigger = false;
  bool remote_local = false;  // REN_CONTROL, GO_TO_LOCAL, LOCAL_LOCKOUT
  bool is_488_2 = false;
  bool service_request = false;
  bool scpi = false;
};
// The 24 bytes that answer kGetCapabilities. kProtocol: too few, or no success.
Result<Capabilities> DecodeCapabilities(std::string_view reply);

// First byte of every answer to a request.
enum class Status : std::uint8_t {
  kSuccess = 0x01,
  kPending = 0x02,
  kFailed = 0x80,  // for an abort: there is nothing to abort
  kTransferNotInProgress = 0x81,
  kSplitNotInProgress = 0x82,
  kSplitInProgress = 0x83,
};
struct StatusReply {
  Status status = Status::kFailed;
  bool more_to_read = false;  // of the answers to checks only: read bulk-in, then check again
};
// kProtocol: shorter than two bytes (one will do for kInitiateClear), or no status there is.
Result<StatusReply> DecodeStatus(Request request, std::string_view reply);

// "pending", "transfer not in progress".
const char* TextOf(Status status);

}  // namespace gonio::usbtmc
