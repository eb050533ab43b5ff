// SPDX-License-Identifier: Apache-2.0
#include "sim/udp_socket.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <utility>

namespace gonio {
namespace {

constexpr std::size_t kLargest = 65536;

sockaddr_in ToSystem(const UdpPeer& peer) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(peer.port);
  address.sin_addr.s_addr = htonl(peer.address);
  return address;
}

}  // namespace

UdpSocket::UdpSocket(const std::string& address, std::uint16_t port) {
  in_addr number{};
  if (inet_pton(AF_INET, address.c_str(), &number) != 1) return;
  handle_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const sockaddr_in own = ToSystem({ntohl(number.s_addr), port});
  if (handle_ >= 0 && bind(handle_, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0) {
    close(std::exchange(handle_, -1));
  }
}

UdpSocket::~UdpSocket() {
  if (handle_ >= 0) close(handle_);
}

void UdpSocket::Send(const UdpPeer& to, std::span<const std::uint8_t> bytes) const {
  const sockaddr_in address = ToSystem(to);
  (void)!sendto(handle_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&address),
                sizeof address);
}

std::optional<Bytes> UdpSocket::Receive(UdpPeer& from) const {
  Bytes bytes(kLargest);
  sockaddr_in address{};
  socklen_t size = sizeof address;
  const ssize_t got = recvfrom(handle_, bytes.data(), bytes.size(), MSG_DONTWAIT,
                               reinterpret_cast<sockaddr*>(&address), &size);
  if (got < 0) return std::nullopt;
  bytes.resize(got);
  from = {ntohl(address.sin_addr.s_addr), ntohs(address.sin_port)};
  return bytes;
}

}  // namespace gonio
