// SPDX-License-Identifier: Apache-2.0
#include "sim/gige_stream.h"

#include <algorithm>

namespace gonio {
namespace {

constexpr int kUdpHeaders = 28;      // bytes of IP and UDP
constexpr int kPacketHeader = 8;     // bytes of GVSP
constexpr std::uint8_t kLeader = 1;  // what a packet is
constexpr std::uint8_t kTrailer = 2;
constexpr std::uint8_t kPayload = 3;
constexpr std::uint32_t kImage = 0x0001;  // what a payload is
constexpr std::uint32_t kWithChunks = 0x4000;

Bytes Packet(std::uint16_t frame, std::uint8_t kind, std::size_t number) {
  Bytes packet;
  PutBigEndian(packet, 0, 2);  // well
  PutBigEndian(packet, frame, 2);
  PutBigEndian(packet, kind, 1);
  PutBigEndian(packet, number, 3);
  return packet;
}

Bytes Leader(std::uint16_t frame, const GigeImage& image) {
  Bytes packet = Packet(frame, kLeader, 0);
  PutBigEndian(packet, 0, 2);
  PutBigEndian(packet, image.chunks ? kImage | kWithChunks : kImage, 2);
  PutBigEndian(packet, frame, 8);  // the camera's clock: counts frames
  for (const std::uint32_t value :
       {image.pixel_format, image.width, image.height, image.x, image.y}) {
    PutBigEndian(packet, value, 4);
  }
  PutBigEndian(packet, 0, 4);  // padding
  return packet;
}

Bytes Trailer(std::uint16_t frame, std::size_t number, const GigeImage& image) {
  Bytes packet = Packet(frame, kTrailer, number);
  PutBigEndian(packet, image.chunks ? kImage | kWithChunks : kImage, 4);
  PutBigEndian(packet, image.height, 4);
  return packet;
}

}  // namespace

void EndChunk(Bytes& payload, std::size_t begin, std::uint32_t id) {
  const std::size_t size = payload.size() - begin;
  PutBigEndian(payload, id, 4);
  PutBigEndian(payload, size, 4);
}

void GigeStream::Send(const GigeImage& image, const UdpPeer& to, int packet_size) {
  const std::lock_guard lock(mutex_);
  if (++frame_ == 0) ++frame_;
  to_ = to;
  const std::size_t room = std::max(1, packet_size - kUdpHeaders - kPacketHeader);
  packets_ = {Leader(frame_, image)};
  for (std::size_t at = 0; at < image.payload.size(); at += room) {
    Bytes packet = Packet(frame_, kPayload, packets_.size());
    const auto begin = image.payload.begin() + at;
    packet.insert(packet.end(), begin, begin + std::min(room, image.payload.size() - at));
    packets_.push_back(std::move(packet));
  }
  packets_.push_back(Trailer(frame_, packets_.size(), image));
  for (const Bytes& packet : packets_) SendPacket(packet);
}

void GigeStream::SendPacket(const Bytes& packet) {
  if (loss_ > 0 && random_.Uniform() < loss_) return;
  socket_.Send(to_, packet);
}

void GigeStream::Resend(std::uint16_t frame, std::uint32_t first, std::uint32_t last) {
  const std::lock_guard lock(mutex_);
  if (frame != frame_) return;
  for (std::size_t i = first; i <= last && i < packets_.size(); ++i) SendPacket(packets_[i]);
}

void GigeStream::SendTest(const UdpPeer& to, int packet_size) {
  const std::lock_guard lock(mutex_);
  socket_.Send(to, Bytes(std::max(0, packet_size - kUdpHeaders)));
}

void GigeStream::SetLoss(double ratio) {
  const std::lock_guard lock(mutex_);
  loss_ = ratio;
}

}  // namespace gonio
