// SPDX-License-Identifier: Apache-2.0
// Datagrams over IPv4.

#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "sim/big_endian.h"

namespace gonio {

struct UdpPeer {
  std::uint32_t address = 0;  // as a number: 127.0.0.1 is 0x7F000001
  std::uint16_t port = 0;
  bool operator==(const UdpPeer&) const = default;
};

class UdpSocket {
 public:
  // Port 0: any that is free. ok() is false if that is not possible.
  UdpSocket(const std::string& address, std::uint16_t port);
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  bool ok() const { return handle_ >= 0; }
  int handle() const { return handle_; }  // for poll()
  // What does not arrive is lost: it is UDP.
  void Send(const UdpPeer& to, std::span<const std::uint8_t> bytes) const;
  // Never waits: empty if there is none.
  std::optional<Bytes> Receive(UdpPeer& from) const;

 private:
  int handle_ = -1;
};

}  // namespace gonio
