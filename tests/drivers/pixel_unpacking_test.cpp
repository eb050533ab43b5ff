// SPDX-License-Identifier: Apache-2.0
#include "drivers/pixel_unpacking.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace gonio {
namespace {

using testing::ElementsAre;

std::vector<std::uint16_t> Unpack(const char* name, const std::vector<std::uint8_t>& bytes,
                                  std::size_t count) {
  const PixelFormat* format = FindPixelFormat(name);
  EXPECT_NE(format, nullptr) << name;
  std::vector<std::uint16_t> counts(count);
  if (format) {
    EXPECT_EQ(format->Bytes(count), bytes.size()) << name;
    UnpackPixels(*format, bytes, counts);
  }
  return counts;
}

// The vectors are by hand from the figures of PFNC and, for "Packed", of GigE Vision. Example
// failures are halves of the middle byte that changed places, and Mono12p read as Mono12Packed.
TEST(PixelUnpacking, BytesAndWords) {
  EXPECT_THAT(Unpack("Mono8", {0, 1, 255}, 3), ElementsAre(0, 1, 255));
  EXPECT_THAT(Unpack("RGB8", {1, 2, 3, 4, 5, 6}, 6), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(Unpack("Mono12", {0xBC, 0x0A, 0xFF, 0x0F}, 2), ElementsAre(0xABC, 0xFFF));
  EXPECT_THAT(Unpack("BayerRG16", {0x34, 0x12, 0xFF, 0xFF}, 2), ElementsAre(0x1234, 0xFFFF));
}

TEST(PixelUnpacking, DropsBitsAboveTheCount) {
  EXPECT_THAT(Unpack("Mono10", {0xFF, 0xFF}, 1), ElementsAre(0x3FF));
  EXPECT_THAT(Unpack("Mono14", {0xFF, 0xFF}, 1), ElementsAre(0x3FFF));
}

TEST(PixelUnpacking, LowestBitFirst) {
  EXPECT_THAT(Unpack("Mono12p", {0xBC, 0x3A, 0x12}, 2), ElementsAre(0xABC, 0x123));
  EXPECT_THAT(Unpack("BayerRG12p", {0xBC, 0x3A, 0x12}, 2), ElementsAre(0xABC, 0x123));
  // 0x2AA, 0x155, 0x3FF, 0x001 are bits 0 to 39.
  EXPECT_THAT(Unpack("Mono10p", {0xAA, 0x56, 0xF5, 0x7F, 0x00}, 4),
              ElementsAre(0x2AA, 0x155, 0x3FF, 0x001));
}

TEST(PixelUnpacking, GigeVisionPacked) {
  EXPECT_THAT(Unpack("Mono12Packed", {0xAB, 0x3C, 0x12}, 2), ElementsAre(0xABC, 0x123));
  EXPECT_THAT(Unpack("Mono10Packed", {0xAA, 0x12, 0x55}, 2), ElementsAre(0x2AA, 0x155));
  // An odd count leaves half of its last byte.
  EXPECT_THAT(Unpack("BayerGB12Packed", {0xAB, 0x3C, 0x12, 0xDE, 0x0F}, 3),
              ElementsAre(0xABC, 0x123, 0xDEF));
}

// Bits 16 to 23 of a PFNC code are the bits of a pixel: a typing error in the table shows.
TEST(PixelUnpacking, CodesSayHowManyBitsAPixelTakes) {
  std::set<std::uint32_t> codes;
  for (const PixelFormat& format : KnownPixelFormats()) {
    const std::size_t bits = (format.code >> 16) & 0xFF;
    EXPECT_EQ(format.Bytes(8 * CountsPerPixel(format.layout)), bits) << format.name;
    EXPECT_TRUE(codes.insert(format.code).second) << format.name;
    EXPECT_EQ(FindPixelFormat(format.name), &format);
  }
  EXPECT_EQ(FindPixelFormat("Mono13"), nullptr);
}

}  // namespace
}  // namespace gonio
