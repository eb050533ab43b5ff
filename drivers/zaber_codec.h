// SPDX-License-Identifier: Apache-2.0
// Zaber's ASCII protocol, versions 2 and 3, as text (https://www.zaber.com/protocol-manual).

#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/error.h"

namespace gonio::zaber {

// One command. Device 0 is all on the chain, axis 0 the device itself or all its axes.
struct Command {
  int device = 0;         // 0 .. 99
  int axis = 0;           // 0 .. 9
  std::optional<int> id;  // 0 .. 255: comes back with the reply
  std::string data;       // "move abs 10000"; empty asks for the status
};

// "/01 1 7 move abs 10000:EB\n". Precondition: data holds none of / @ # ! : \ CR LF, nor bytes from
// 0x80 on, and the line has at most kMostBytes.
inline constexpr std::size_t kMostBytes = 80;  // of a packet, unless a device was told otherwise
std::string Encode(const Command& command);

enum class Kind {
  kReply,  // '@': to a command
  kInfo,   // '#': more of a reply, or for people
  kAlert,  // '!': unasked
};

struct Message {
  Kind kind = Kind::kReply;
  int device = 0;
  int axis = 0;
  std::optional<int> id;  // never of alerts
  bool accepted = false;  // of replies: OK, else RJ, with the reason in data
  bool busy = false;      // of replies and alerts
  std::string warning;    // of replies and alerts: the gravest flag, "WR"; empty for "--"
  std::string data;
  bool continued = false;  // the packet was too short: what is missing follows in info messages
};

// A line without its CR LF. kProtocol: not a message, or its checksum is wrong. A message need not
// have a checksum, nor an id: info without one that begins with a number reads as if it had, so
// give commands ids.
Result<Message> Decode(std::string_view line);

// Two hexadecimal digits: what the bytes between the first one and ':' lack to 256.
std::string Checksum(std::string_view bytes);

}  // namespace gonio::zaber
