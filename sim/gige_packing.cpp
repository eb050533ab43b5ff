// SPDX-License-Identifier: Apache-2.0
#include "sim/gige_packing.h"

#include <algorithm>

namespace gonio {

const std::vector<GigeFormat>& GigeFormats() {
  // Bits 16 to 23 of a code are the bits of a pixel.
  static const std::vector<GigeFormat> formats = {
      {"Mono8", 0x01080001, PixelLayout::kMono, 8, 8, false},
      {"Mono10", 0x01100003, PixelLayout::kMono, 10, 16, false},
      {"Mono12", 0x01100005, PixelLayout::kMono, 12, 16, false},
      {"Mono16", 0x01100007, PixelLayout::kMono, 16, 16, false},
      {"Mono10p", 0x010A0046, PixelLayout::kMono, 10, 10, false},
      {"Mono12p", 0x010C0047, PixelLayout::kMono, 12, 12, false},
      {"Mono12Packed", 0x010C0006, PixelLayout::kMono, 12, 12, true},
      {"BayerRG8", 0x01080009, PixelLayout::kBayerRg, 8, 8, false},
      {"BayerRG12", 0x01100011, PixelLayout::kBayerRg, 12, 16, false},
      {"BayerRG12p", 0x010C0059, PixelLayout::kBayerRg, 12, 12, false},
      {"RGB8", 0x02180014, PixelLayout::kRgb, 8, 8, false},
  };
  return formats;
}

void PackCounts(const GigeFormat& format, const std::vector<std::uint16_t>& counts,
                std::uint8_t* bytes) {
  if (format.paired) {
    for (std::size_t i = 0; i + 1 < counts.size(); i += 2, bytes += 3) {
      bytes[0] = static_cast<std::uint8_t>(counts[i] >> 4);
      bytes[1] = static_cast<std::uint8_t>((counts[i] & 0xF) | (counts[i + 1] & 0xF) << 4);
      bytes[2] = static_cast<std::uint8_t>(counts[i + 1] >> 4);
    }
    return;
  }
  // All others are little-endian, and bit i of the image is bit i % 8 of its byte i / 8.
  std::fill_n(bytes, counts.size() * format.wire_bits / 8, std::uint8_t{0});
  std::size_t at = 0;
  for (const std::uint16_t count : counts) {
    for (int bit = 0; bit < format.wire_bits; bit += 8) {
      const unsigned part = (count >> bit) & 0xFFu;
      const unsigned shifted = part << (at + bit) % 8;
      const std::size_t byte = (at + bit) / 8;
      bytes[byte] |= static_cast<std::uint8_t>(shifted);
      if (shifted > 0xFF) bytes[byte + 1] |= static_cast<std::uint8_t>(shifted >> 8);
    }
    at += format.wire_bits;
  }
}

}  // namespace gonio
