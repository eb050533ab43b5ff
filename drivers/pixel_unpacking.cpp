// SPDX-License-Identifier: Apache-2.0
#include "drivers/pixel_unpacking.h"

#include <algorithm>

#include "core/check.h"

namespace gonio {
namespace {

int BitsOnTheWire(const PixelFormat& format) {
  switch (format.packing) {
    case PixelPacking::kBytes:
      return 8;
    case PixelPacking::kWords:
      return 16;
    case PixelPacking::kLsbPacked:
      return format.bits;
    case PixelPacking::kGigePacked:
      return 12;  // of 10, too
  }
  GONIO_CHECK(false, "no packing");
}

struct Family {
  const char* name;
  PixelLayout layout;
  // The codes of 8, 10, 12 and 16 bits, of 10p and 12p, of 10Packed and 12Packed; 0: there is none.
  std::uint32_t codes[8];
};
constexpr Family kFamilies[] = {
    {"Mono",
     PixelLayout::kMono,
     {0x01080001, 0x01100003, 0x01100005, 0x01100007, 0x010a0046, 0x010c0047, 0x010c0004,
      0x010c0006}},
    {"BayerGR",
     PixelLayout::kBayerGr,
     {0x01080008, 0x0110000c, 0x01100010, 0x0110002e, 0x010a0056, 0x010c0057, 0x010c0026,
      0x010c002a}},
    {"BayerRG",
     PixelLayout::kBayerRg,
     {0x01080009, 0x0110000d, 0x01100011, 0x0110002f, 0x010a0058, 0x010c0059, 0x010c0027,
      0x010c002b}},
    {"BayerGB",
     PixelLayout::kBayerGb,
     {0x0108000a, 0x0110000e, 0x01100012, 0x01100030, 0x010a0054, 0x010c0055, 0x010c0028,
      0x010c002c}},
    {"BayerBG",
     PixelLayout::kBayerBg,
     {0x0108000b, 0x0110000f, 0x01100013, 0x01100031, 0x010a0052, 0x010c0053, 0x010c0029,
      0x010c002d}},
    {"RGB", PixelLayout::kRgb, {0x02180014, 0x02300018, 0x0230001a, 0x02300033, 0, 0, 0, 0}},
};
struct Depth {
  const char* suffix;
  int bits;
  PixelPacking packing;
};
constexpr Depth kDepths[8] = {
    {"8", 8, PixelPacking::kBytes},
    {"10", 10, PixelPacking::kWords},
    {"12", 12, PixelPacking::kWords},
    {"16", 16, PixelPacking::kWords},
    {"10p", 10, PixelPacking::kLsbPacked},
    {"12p", 12, PixelPacking::kLsbPacked},
    {"10Packed", 10, PixelPacking::kGigePacked},
    {"12Packed", 12, PixelPacking::kGigePacked},
};

std::vector<PixelFormat> MakeFormats() {
  std::vector<PixelFormat> formats;
  for (const Family& family : kFamilies) {
    for (std::size_t i = 0; i < std::size(kDepths); ++i) {
      if (family.codes[i] == 0) continue;
      const Depth& depth = kDepths[i];
      formats.push_back({.name = std::string(family.name) + depth.suffix,
                         .code = family.codes[i],
                         .layout = family.layout,
                         .bits = depth.bits,
                         .packing = depth.packing});
    }
  }
  formats.push_back({.name = "Mono14",
                     .code = 0x01100025,
                     .layout = PixelLayout::kMono,
                     .bits = 14,
                     .packing = PixelPacking::kWords});
  return formats;
}

void UnpackLsb(int bits, std::span<const std::uint8_t> bytes, std::span<std::uint16_t> counts) {
  std::uint32_t held = 0;
  int held_bits = 0;
  std::size_t next = 0;
  const std::uint32_t mask = (1u << bits) - 1;
  for (std::uint16_t& count : counts) {
    while (held_bits < bits) {
      held |= static_cast<std::uint32_t>(bytes[next++]) << held_bits;
      held_bits += 8;
    }
    count = static_cast<std::uint16_t>(held & mask);
    held >>= bits;
    held_bits -= bits;
  }
}

// Of the middle byte, the first count has the low half, the second the high one.
void UnpackGige(int bits, std::span<const std::uint8_t> bytes, std::span<std::uint16_t> counts) {
  const int low_bits = bits - 8;
  const int low_mask = (1 << low_bits) - 1;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const std::size_t pair = i / 2 * 3;
    const bool second = i % 2 == 1;
    const int high = bytes[pair + (second ? 2 : 0)];
    const int low = bytes[pair + 1] >> (second ? 4 : 0);
    counts[i] = static_cast<std::uint16_t>(high << low_bits | (low & low_mask));
  }
}

}  // namespace

std::size_t PixelFormat::Bytes(std::size_t counts) const {
  return (counts * BitsOnTheWire(*this) + 7) / 8;
}

const std::vector<PixelFormat>& KnownPixelFormats() {
  static const std::vector<PixelFormat> formats = MakeFormats();
  return formats;
}

const PixelFormat* FindPixelFormat(std::string_view name) {
  const auto& formats = KnownPixelFormats();
  const auto found = std::find_if(formats.begin(), formats.end(),
                                  [&](const PixelFormat& format) { return format.name == name; });
  return found == formats.end() ? nullptr : &*found;
}

void UnpackPixels(const PixelFormat& format, std::span<const std::uint8_t> bytes,
                  std::span<std::uint16_t> counts) {
  GONIO_CHECK(bytes.size() >= format.Bytes(counts.size()), "an image of fewer bytes than pixels");
  switch (format.packing) {
    case PixelPacking::kBytes:
      std::copy_n(bytes.begin(), counts.size(), counts.begin());
      return;
    case PixelPacking::kWords:
      for (std::size_t i = 0; i < counts.size(); ++i) {
        const int word = bytes[2 * i] | bytes[2 * i + 1] << 8;
        counts[i] = static_cast<std::uint16_t>(word & format.full_scale());
      }
      return;
    case PixelPacking::kLsbPacked:
      UnpackLsb(format.bits, bytes, counts);
      return;
    case PixelPacking::kGigePacked:
      UnpackGige(format.bits, bytes, counts);
      return;
  }
}

}  // namespace gonio
