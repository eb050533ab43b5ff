// SPDX-License-Identifier: Apache-2.0
// Counts as the bytes that a GigE Vision camera sends.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/camera.h"

namespace gonio {

// Apart from drivers/pixel_unpacking.h on purpose: a mistake there would be made here as well.
struct GigeFormat {
  std::string name;
  std::uint32_t code = 0;  // PFNC
  PixelLayout layout = PixelLayout::kMono;
  int bits = 8;         // of a count
  int wire_bits = 8;    // that a count takes
  bool paired = false;  // GigE Vision's "Packed": two counts share their middle byte
};
const std::vector<GigeFormat>& GigeFormats();

// Writes into `bytes`, which has room for counts.size() * wire_bits / 8.
void PackCounts(const GigeFormat& format, const std::vector<std::uint16_t>& counts,
                std::uint8_t* bytes);

}  // namespace gonio
