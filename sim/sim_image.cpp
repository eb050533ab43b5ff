// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_image.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace gonio {
namespace {

// Weights of a Gaussian, at -radius .. radius, whose sum is 1.
std::vector<float> GaussianKernel(double sigma, int radius) {
  std::vector<float> kernel;
  float sum = 0;
  for (int i = -radius; i <= radius; ++i) {
    kernel.push_back(static_cast<float>(std::exp(-i * i / (2 * sigma * sigma))));
    sum += kernel.back();
  }
  for (float& weight : kernel) weight /= sum;
  return kernel;
}

// One row of `out` gets the weighted sum of rows that begin `step` values apart.
void Convolve(const std::vector<float>& kernel, const float* in, std::size_t step, int width,
              float* out) {
  std::fill_n(out, width, 0.F);
  for (const float weight : kernel) {
    for (int x = 0; x < width; ++x) out[x] += weight * in[x];
    in += step;
  }
}

}  // namespace

SimImage& SimImage::operator+=(const SimImage& other) {
  GONIO_CHECK(width == other.width && height == other.height, "an image of another size");
  if (planes == 0 && other.planes > 0) {
    GONIO_CHECK((uniform <= 0).all(), "the sum of a uniform image and another");
    return *this = other;
  }
  uniform += other.uniform;
  for (std::size_t i = 0; i < other.values.size(); ++i) values[i] += other.values[i];
  return *this;
}

SimImage& SimImage::operator*=(double factor) {
  uniform *= factor;
  for (float& value : values) value *= static_cast<float>(factor);
  return *this;
}

SimImage Blur(const SimImage& image, double sigma, int margin) {
  SimImage blurred{.width = image.width - 2 * margin,
                   .height = image.height - 2 * margin,
                   .planes = image.planes,
                   .values = {}};
  blurred.values.resize(blurred.pixels() * image.planes);
  const std::vector<float> kernel = GaussianKernel(sigma, margin);
  const auto width = static_cast<std::size_t>(blurred.width);
  std::vector<float> rows(width * image.height);
  for (int c = 0; c < image.planes; ++c) {
    const float* in = image.values.data() + c * image.pixels();
    for (int y = 0; y < image.height; ++y) {
      Convolve(kernel, in + static_cast<std::size_t>(y) * image.width, 1, blurred.width,
               rows.data() + y * width);
    }
    float* out = blurred.values.data() + c * blurred.pixels();
    for (int y = 0; y < blurred.height; ++y) {
      Convolve(kernel, rows.data() + y * width, width, blurred.width, out + y * width);
    }
  }
  return blurred;
}

void AddGlare(SimImage& image, double fraction) {
  for (int c = 0; c < image.planes; ++c) {
    float* plane = image.values.data() + c * image.pixels();
    double sum = 0;
    for (std::size_t i = 0; i < image.pixels(); ++i) sum += plane[i];
    const auto veil = static_cast<float>(fraction * sum / static_cast<double>(image.pixels()));
    for (std::size_t i = 0; i < image.pixels(); ++i) plane[i] += veil;
  }
}

}  // namespace gonio
