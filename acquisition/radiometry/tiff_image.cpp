// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/tiff_image.h"

#include <fmt/format.h>

#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <utility>

#include "core/error.h"

namespace gonio {
namespace {

// OpenCV's order of colours is blue, green, red: swapped, so that other programs see them right.
template <typename Value>
void SwapRedAndBlue(const ImageSize& size, std::vector<Value>* values) {
  if (size.per_pixel != 3) return;
  for (std::size_t i = 0; i < values->size(); i += 3) std::swap((*values)[i], (*values)[i + 2]);
}

template <typename Value>
constexpr int kDepth = sizeof(Value) == sizeof(float) ? CV_32F : CV_16U;

template <typename Value>
std::string Encode(const std::filesystem::path& path, const ImageSize& size,
                   std::vector<Value> values) {
  SwapRedAndBlue(size, &values);
  const cv::Mat mat(size.height, size.width, CV_MAKETYPE(kDepth<Value>, size.per_pixel),
                    values.data());
  std::vector<unsigned char> bytes;
  bool done = false;
  try {
    // Unless told not to compress, OpenCV keeps three floats as LogLuv, good to a per cent.
    done = cv::imencode(".tiff", mat, bytes, {cv::IMWRITE_TIFF_COMPRESSION, 1});
  } catch (const cv::Exception&) {
  }
  if (!done) throw std::runtime_error(path.string() + ": cannot write: OpenCV cannot encode it");
  return {bytes.begin(), bytes.end()};
}

template <typename Value>
std::vector<Value> Decode(const std::filesystem::path& path, const ImageSize& size,
                          const std::string& bytes) {
  const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8U,
                       const_cast<char*>(bytes.data()));  // NOLINT: only read
  cv::Mat mat;
  try {
    mat = cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
  }
  if (mat.empty()) throw ConfigError(path.string() + ": is no TIFF image");
  if (mat.cols != size.width || mat.rows != size.height ||
      mat.type() != CV_MAKETYPE(kDepth<Value>, size.per_pixel)) {
    throw ConfigError(fmt::format("{}: must be {} x {} pixels of {} {}", path.string(), size.width,
                                  size.height, size.per_pixel,
                                  kDepth<Value> == CV_32F ? "floats" : "16-bit counts"));
  }
  const auto row = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.per_pixel);
  std::vector<Value> values(row * static_cast<std::size_t>(size.height));
  for (int y = 0; y < mat.rows; ++y) {
    std::memcpy(values.data() + static_cast<std::size_t>(y) * row, mat.ptr<Value>(y),
                row * sizeof(Value));
  }
  SwapRedAndBlue(size, &values);
  return values;
}

}  // namespace

std::string EncodeTiff(const std::filesystem::path& path, const ImageSize& size,
                       std::vector<float> values) {
  return Encode(path, size, std::move(values));
}

std::string EncodeTiff(const std::filesystem::path& path, const ImageSize& size,
                       std::vector<std::uint16_t> values) {
  return Encode(path, size, std::move(values));
}

std::vector<float> DecodeTiffFloats(const std::filesystem::path& path, const ImageSize& size,
                                    const std::string& bytes) {
  return Decode<float>(path, size, bytes);
}

std::vector<std::uint16_t> DecodeTiffCounts(const std::filesystem::path& path,
                                            const ImageSize& size, const std::string& bytes) {
  return Decode<std::uint16_t>(path, size, bytes);
}

}  // namespace gonio
