// SPDX-License-Identifier: Apache-2.0
// The stream channel of a GigE Vision camera (GVSP): images as packets.

#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "sim/random.h"
#include "sim/udp_socket.h"

namespace gonio {

struct GigeImage {
  std::uint32_t pixel_format = 0;  // PFNC
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool chunks = false;  // the payload is chunks, of which the image is the first
  Bytes payload;
};

// Ends what was put into `payload` since it had `begin` bytes as the chunk of this number: its
// number and length follow the data, so that clients read from the end.
void EndChunk(Bytes& payload, std::size_t begin, std::uint32_t id);

// Any thread.
class GigeStream {
 public:
  GigeStream(const std::string& address, std::uint64_t seed)
      : socket_(address, 0), random_(seed, 0) {}

  // Sends it as packets of `packet_size` bytes, IP and UDP headers included.
  void Send(const GigeImage& image, const UdpPeer& to, int packet_size);
  // Sends packets of the last frame again, if it is `frame`.
  void Resend(std::uint16_t frame, std::uint32_t first, std::uint32_t last);
  // A packet of this size, that a client looks for to learn what the network lets through.
  void SendTest(const UdpPeer& to, int packet_size);

  void SetLoss(double ratio);

 private:
  void SendPacket(const Bytes& packet);

  std::mutex mutex_;
  const UdpSocket socket_;
  Random random_;
  double loss_ = 0;
  std::uint16_t frame_ = 0;  // the last one's number, from 1
  UdpPeer to_;               // where it went
  std::vector<Bytes> packets_;
};

}  // namespace gonio
