// SPDX-License-Identifier: Apache-2.0
#include "acquisition/wal_tail.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <span>
#include <vector>

namespace gonio {
namespace {

constexpr std::uint32_t kMagic = 0x377f0682;  // the last bit: checksums are big-endian
constexpr std::size_t kHeader = 32;
constexpr std::size_t kFrameHeader = 24;

using Bytes = std::span<const std::uint8_t>;
using Checksum = std::array<std::uint32_t, 2>;

std::uint32_t Big(Bytes bytes, std::size_t at) {
  return std::uint32_t{bytes[at]} << 24 | std::uint32_t{bytes[at + 1]} << 16 |
         std::uint32_t{bytes[at + 2]} << 8 | std::uint32_t{bytes[at + 3]};
}

std::uint32_t Little(Bytes bytes, std::size_t at) {
  return std::uint32_t{bytes[at + 3]} << 24 | std::uint32_t{bytes[at + 2]} << 16 |
         std::uint32_t{bytes[at + 1]} << 8 | std::uint32_t{bytes[at]};
}

Checksum Continue(Checksum sum, Bytes bytes, bool big) {
  const auto word = [&](std::size_t at) { return big ? Big(bytes, at) : Little(bytes, at); };
  for (std::size_t at = 0; at + 8 <= bytes.size(); at += 8) {
    sum[0] += word(at) + sum[1];
    sum[1] += word(at + 4) + sum[0];
  }
  return sum;
}

}  // namespace

WalTail ReadWalTail(const std::filesystem::path& wal) {
  std::ifstream file(wal, std::ios::binary);
  const std::vector<char> chars((std::istreambuf_iterator<char>(file)), {});
  const Bytes all(reinterpret_cast<const std::uint8_t*>(chars.data()), chars.size());
  WalTail tail;
  if (all.size() < kHeader || (Big(all, 0) & ~1u) != kMagic) return tail;
  const bool big = (Big(all, 0) & 1) != 0;
  const std::size_t page = Big(all, 8);
  const Bytes salts = all.subspan(16, 8);
  Checksum sum = Continue({}, all.first(24), big);
  const std::size_t frame = kFrameHeader + page;
  for (std::size_t at = kHeader; page > 0 && at + kFrameHeader <= all.size(); at += frame) {
    const Bytes header = all.subspan(at, kFrameHeader);
    // Frames of an earlier round through the log are no part of it.
    if (!std::equal(salts.begin(), salts.end(), header.begin() + 8)) break;
    // A frame is written in two parts, so a process that was killed may leave its header alone.
    if (at + frame > all.size()) break;
    bool sound = tail.damaged == 0;
    if (sound) {
      sum = Continue(sum, header.first(8), big);
      sum = Continue(sum, all.subspan(at + kFrameHeader, page), big);
      sound = sum[0] == Big(header, 16) && sum[1] == Big(header, 20);
    }
    if (!sound) {
      ++tail.damaged;
      continue;
    }
    ++tail.unfinished;
    if (Big(header, 4) == 0) continue;  // not the last of its transaction
    tail.committed += tail.unfinished;
    tail.unfinished = 0;
  }
  return tail;
}

}  // namespace gonio
