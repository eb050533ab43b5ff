// SPDX-License-Identifier: Apache-2.0
#include "brdf/render/image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/file.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

Image Ramp() {
  Image image(20, 12);
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 20; ++x) image.at(x, y) = {0.01f * x, 100.0f * y, 1.0f + x + y};
  }
  return image;
}

TEST(Image, ReadsBackWhatItWrote) {
  const TempDir dir;
  const Image ramp = Ramp();
  // OpenEXR by OpenCV holds single precision; Radiance an 8-bit mantissa common to the colours.
  for (const auto& [name, error] : {std::pair{"i.exr", 1e-6f}, std::pair{"i.hdr", 0.008f}}) {
    WriteImage(dir / name, ramp);
    const Image read = ReadImage(dir / name);
    ASSERT_EQ(read.width, 20);
    ASSERT_EQ(read.height, 12);
    for (std::size_t i = 0; i < read.pixels.size(); ++i) {
      const float scale = ramp.pixels[i].maxCoeff();
      EXPECT_LT((read.pixels[i] - ramp.pixels[i]).abs().maxCoeff(), error * scale) << name;
    }
  }
}

TEST(Image, ComplainsOfFilesItCannotRead) {
  const TempDir dir;
  const auto message = [](const std::filesystem::path& path) {
    return MessageOf<ConfigError>([&] { ReadImage(path); });
  };
  EXPECT_THAT(message(dir / "none.exr"), HasSubstr("none.exr: no such file"));
  EXPECT_THAT(message(dir / "x.png"), HasSubstr("must be .hdr or .exr"));
  EXPECT_THAT(message(dir.File("text.hdr", "no image")), HasSubstr("text.hdr: "));
  EXPECT_THROW(WriteImage(dir / "x.jpg", Ramp()), ConfigError);
  EXPECT_THROW(WritePng(dir / "x.hdr", Ramp()), ConfigError);
  EXPECT_THROW(WritePng(dir / "nowhere/x.png", Ramp()), std::runtime_error);
}

TEST(Image, RefusesPixelsThatAreNotFinite) {
  const TempDir dir;
  Image image = Ramp();
  image.at(3, 4)[1] = std::numeric_limits<float>::infinity();
  WriteImage(dir / "i.exr", image);
  EXPECT_THAT(MessageOf<ConfigError>([&] { ReadImage(dir / "i.exr"); }),
              HasSubstr("pixel (3, 4) is not finite"));
}

TEST(ToneMap, EncodesSrgb) {
  Image image(3, 1);
  image.at(0, 0).setConstant(0.5f);
  image.at(1, 0).setConstant(0.001f);
  image.at(2, 0).setConstant(7);
  const Image shown = ToneMap(image, 0.5);
  EXPECT_NEAR(shown.at(0, 0)[0], 0.537099, 1e-5);  // IEC 61966-2-1 of 0.25
  EXPECT_NEAR(shown.at(1, 0)[1], 12.92 * 0.0005, 1e-7);
  EXPECT_EQ(shown.at(2, 0)[2], 1);
}

TEST(AutoExposure, MakesAllButTheBrightestHundredthVisible) {
  Image image(20, 10);
  for (int i = 0; i < 200; ++i) image.pixels[i].setConstant(i < 100 ? 0 : 0.01f * (i - 99));
  EXPECT_NEAR(AutoExposure(image), 1 / 0.99, 0.01);  // of the lit pixels
  EXPECT_EQ(AutoExposure(Image(4, 4)), 1);
}

TEST(WritePng, LeavesAPng) {
  const TempDir dir;
  WritePng(dir / "i.png", ToneMap(Ramp(), 0.1));
  EXPECT_THAT(ReadTextFile(dir / "i.png"), StartsWith("\x89PNG"));
  EXPECT_EQ(dir.CountFiles(), 1u);
}

}  // namespace
}  // namespace gonio
