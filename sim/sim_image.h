// SPDX-License-Identifier: Apache-2.0
// Light on a sensor, before it is counted.

#pragma once

#include <cstddef>
#include <vector>

#include "brdf/brdf.h"

namespace gonio {

// A part of the sensor: columns x .. x + width - 1, rows y .. y + height - 1.
struct SimRegion {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

// Electrons per pixel without noise, or their rate.
struct SimImage {
  int width = 0;
  int height = 0;
  // 0: every pixel sees `uniform`. 1: monochrome, the mean of the three channels. 3: red, green,
  // blue, one plane after the other, each row by row.
  int planes = 0;
  Rgb uniform = Rgb::Zero();
  std::vector<float> values;

  std::size_t pixels() const { return static_cast<std::size_t>(width) * height; }

  // Of the same size. Only darkness is added to an image of the other kind.
  SimImage& operator+=(const SimImage& other);
  SimImage& operator*=(double factor);
};

// The image within `margin` pixels of the given one's border, blurred by a Gaussian that reaches as
// far; sigma in pixels.
SimImage Blur(const SimImage& image, double sigma, int margin);

// Adds this fraction of a plane's mean to each of its pixels.
void AddGlare(SimImage& image, double fraction);

}  // namespace gonio
