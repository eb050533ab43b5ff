// SPDX-License-Identifier: Apache-2.0
// The pixel formats of GenICam cameras, and their bytes as counts.

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/camera.h"

namespace gonio {

// How the counts of an image lie in its bytes, one after the other across the ends of rows.
enum class PixelPacking {
  kBytes,       // 8 bits: "Mono8"
  kWords,       // 16 bits, little-endian, the count in the low bits: "Mono10", "Mono12", "Mono16"
  kLsbPacked,   // bit after bit, the lowest first: "Mono10p", "Mono12p"
  kGigePacked,  // two counts in three bytes, low bits in the middle one: "Mono12Packed"
};

// A format of GenICam's Pixel Format Naming Convention (PFNC 2.1; the packed ones are from GigE
// Vision 1.2). Counts are unsigned; those of Bayer mosaics and of RGB lie as those of mono do.
struct PixelFormat {
  std::string name;        // of the camera's PixelFormat: "BayerRG12p"
  std::uint32_t code = 0;  // on the wire
  PixelLayout layout = PixelLayout::kMono;
  int bits = 8;  // of a count
  PixelPacking packing = PixelPacking::kBytes;

  int full_scale() const { return (1 << bits) - 1; }  // counts
  // Of so many counts, rounded up.
  std::size_t Bytes(std::size_t counts) const;
};

// Those that UnpackPixels() knows, by name; nullptr if there is none of it.
const std::vector<PixelFormat>& KnownPixelFormats();
const PixelFormat* FindPixelFormat(std::string_view name);

// Right-aligned counts: full scale of 12 bits is 4095 in any packing. Bits above the count's own
// are dropped. Precondition: bytes.size() >= format.Bytes(counts.size()).
void UnpackPixels(const PixelFormat& format, std::span<const std::uint8_t> bytes,
                  std::span<std::uint16_t> counts);

}  // namespace gonio
