// SPDX-License-Identifier: Apache-2.0
#include "brdf/render/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

#include "core/error.h"
#include "core/file.h"

namespace gonio {
namespace {

constexpr double kWhiteQuantile = 0.99;

std::string Extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

void RequireLinear(const std::filesystem::path& path) {
  const std::string extension = Extension(path);
  if (extension != ".hdr" && extension != ".exr") {
    throw ConfigError(fmt::format("{}: has the extension \"{}\", must be .hdr or .exr (linear)",
                                  path.string(), path.extension().string()));
  }
  // OpenCV reads and writes OpenEXR only if told so, before it is first asked.
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 0);
}

// OpenCV's order of the colours is blue, green, red.
cv::Mat ToMat(const Image& image) {
  cv::Mat mat(image.height, image.width, CV_32FC3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Eigen::Array3f& rgb = image.at(x, y);
      mat.at<cv::Vec3f>(y, x) = {rgb[2], rgb[1], rgb[0]};
    }
  }
  return mat;
}

void WriteEncoded(const std::filesystem::path& path, const cv::Mat& mat) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(Extension(path), mat, bytes)) {
    throw std::runtime_error(path.string() + ": cannot write: OpenCV cannot encode it");
  }
  WriteFileAtomically(path, [&](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
  });
}

// IEC 61966-2-1.
float EncodeSrgb(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  return static_cast<float>(x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
}

}  // namespace

double AutoExposure(const Image& image) {
  std::vector<float> lit;
  for (const Eigen::Array3f& pixel : image.pixels) {
    if (pixel.maxCoeff() > 0) lit.push_back(pixel.maxCoeff());
  }
  if (lit.empty()) return 1;
  const auto at = lit.begin() + static_cast<std::ptrdiff_t>(kWhiteQuantile * (lit.size() - 1.0));
  std::nth_element(lit.begin(), at, lit.end());
  return 1.0 / *at;
}

Image ToneMap(const Image& image, double exposure) {
  Image shown(image.width, image.height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) shown.pixels[i][c] = EncodeSrgb(exposure * image.pixels[i][c]);
  }
  return shown;
}

Image ReadImage(const std::filesystem::path& path) {
  RequireLinear(path);
  if (!std::filesystem::exists(path)) throw ConfigError(path.string() + ": no such file");
  cv::Mat mat;
  try {
    mat = cv::imread(path.string(), cv::IMREAD_ANYDEPTH | cv::IMREAD_COLOR);
  } catch (const cv::Exception& e) {
    throw ConfigError(path.string() + ": cannot read: " + e.err);
  }
  if (mat.empty() || mat.type() != CV_32FC3) {
    throw ConfigError(path.string() + ": is no image with linear colours");
  }
  Image image(mat.cols, mat.rows);
  for (int y = 0; y < mat.rows; ++y) {
    for (int x = 0; x < mat.cols; ++x) {
      const cv::Vec3f& bgr = mat.at<cv::Vec3f>(y, x);
      image.at(x, y) = {bgr[2], bgr[1], bgr[0]};
      if (!image.at(x, y).isFinite().all()) {
        throw ConfigError(fmt::format("{}: pixel ({}, {}) is not finite", path.string(), x, y));
      }
    }
  }
  return image;
}

void WriteImage(const std::filesystem::path& path, const Image& linear) {
  RequireLinear(path);
  WriteEncoded(path, ToMat(linear));
}

void WritePng(const std::filesystem::path& path, const Image& tone_mapped) {
  if (Extension(path) != ".png") throw ConfigError(path.string() + ": is no .png");
  cv::Mat mat;
  ToMat(tone_mapped).convertTo(mat, CV_8UC3, 255);  // rounds and clips
  WriteEncoded(path, mat);
}

}  // namespace gonio
