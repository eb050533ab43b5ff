// SPDX-License-Identifier: Apache-2.0
// Colour images with linear radiance, and their files.

#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace gonio {

// Pixels row by row from the top left; red, green, blue with Rec. 709 primaries, linear, in any
// unit. Not a drivers' Frame, which holds counts.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<Eigen::Array3f> pixels;  // width * height

  Image() = default;
  Image(int w, int h)
      : width(w), height(h), pixels(static_cast<std::size_t>(w) * h, Eigen::Array3f::Zero()) {}
  Eigen::Array3f& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
  const Eigen::Array3f& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * width + x];
  }
};

// The exposure at which the 99th percentile of the brightest channel of the lit pixels is white:
// what the linear values are multiplied by before they are shown. > 0; 1 for a black image.
double AutoExposure(const Image& image);

// sRGB code values 0 .. 1 (IEC 61966-2-1): exposed, clipped, encoded. What a PNG holds and what
// people see.
Image ToneMap(const Image& image, double exposure);

// By extension: .hdr (Radiance) and .exr (OpenEXR) are linear and read back within their precision.
// Throws ConfigError "PATH: ..." on other extensions, and on reading what is missing or no image.
Image ReadImage(const std::filesystem::path& path);
// Whole or not at all. Throws ConfigError on other extensions, std::runtime_error on failure.
void WriteImage(const std::filesystem::path& path, const Image& linear);

// 8-bit PNG of an image that is already tone-mapped.
void WritePng(const std::filesystem::path& path, const Image& tone_mapped);

}  // namespace gonio
