// SPDX-License-Identifier: Apache-2.0
#include "brdf/render/environment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/units.h"

namespace gonio {
namespace {

constexpr int kSkyWidth = 512;
constexpr int kSkyHeight = 256;

double Luminance(const Eigen::Array3f& rgb) {  // of Rec. 709 colours
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// Columns run from +z (behind the camera) over -x to -z (the centre), +x and back; rows from +y
// down.
Eigen::Vector3d DirectionAt(double u, double v) {
  const double azimuth = 2 * kPi * (u - 0.5);  // 0 at -z, positive towards +x
  const double polar = kPi * v;                // from +y
  return {std::sin(polar) * std::sin(azimuth), std::cos(polar),
          -std::sin(polar) * std::cos(azimuth)};
}

struct Place {
  double u, v;  // 0 .. 1
};
Place PlaceOf(const Eigen::Vector3d& direction) {
  const double azimuth = std::atan2(direction.x(), -direction.z());
  const double polar = std::atan2(std::hypot(direction.x(), direction.z()), direction.y());
  return {azimuth / (2 * kPi) + 0.5, polar / kPi};
}

int Clip(double at, int count) { return std::clamp(static_cast<int>(at), 0, count - 1); }

// Solid angle of a pixel in a row.
double SolidAngle(const Image& image, int row) {
  const double top = kPi * row / image.height;
  const double bottom = kPi * (row + 1) / image.height;
  return 2 * kPi / image.width * (std::cos(top) - std::cos(bottom));
}

// The sky before it is scaled; docs/rendering.md explains its terms.
Eigen::Array3f SkyRadiance(const Eigen::Vector3d& direction) {
  static const Eigen::Vector3d sun = Eigen::Vector3d(-0.5, 0.65, 0.57).normalized();
  const Eigen::Array3f zenith(0.20f, 0.38f, 0.85f);
  const Eigen::Array3f horizon(0.85f, 0.92f, 1.0f);
  const Eigen::Array3f ground(0.20f, 0.17f, 0.14f);
  const Eigen::Array3f sunlight(1.0f, 0.93f, 0.80f);
  const double height = direction.y();
  const double from_sun = std::acos(std::clamp(direction.dot(sun), -1.0, 1.0));
  constexpr double kSunRadius = RadFromDeg(3);
  constexpr double kGlow = RadFromDeg(18);
  Eigen::Array3f radiance = ground;
  if (height > 0) {
    const auto haze = static_cast<float>(std::exp(-5 * height));
    radiance = zenith + haze * (horizon - zenith);
    radiance += static_cast<float>(1.5 * std::exp(-from_sun / kGlow)) * sunlight;
  }
  // A disc with a soft rim of half a degree, so that its edge does not alias.
  const double rim = std::clamp((kSunRadius - from_sun) / RadFromDeg(0.5) + 0.5, 0.0, 1.0);
  return radiance + static_cast<float>(150 * rim) * sunlight;
}

}  // namespace

Environment::Environment(Image image) : image_(std::move(image)) {
  const int width = image_.width;
  const int height = image_.height;
  row_cdf_.assign(height + 1, 0);
  column_cdf_.assign(std::size_t(height) * (width + 1), 0);
  for (int y = 0; y < height; ++y) {
    double* cdf = column_cdf_.data() + std::size_t(y) * (width + 1);
    for (int x = 0; x < width; ++x) cdf[x + 1] = cdf[x] + Luminance(image_.at(x, y));
    row_cdf_[y + 1] = row_cdf_[y] + cdf[width] * SolidAngle(image_, y);
    const double sum = cdf[width];
    for (int x = 0; x <= width && sum > 0; ++x) cdf[x] /= sum;
  }
  total_ = row_cdf_[height];
  if (!(total_ > 0)) throw ConfigError("environment: is black");
  for (double& share : row_cdf_) share /= total_;
}

Environment Environment::Sky() {
  Image image(kSkyWidth, kSkyHeight);
  double irradiance = 0;  // on a horizontal surface, luminance
  for (int y = 0; y < kSkyHeight; ++y) {
    for (int x = 0; x < kSkyWidth; ++x) {
      const Eigen::Vector3d direction = DirectionAt((x + 0.5) / kSkyWidth, (y + 0.5) / kSkyHeight);
      image.at(x, y) = SkyRadiance(direction);
      irradiance += Luminance(image.at(x, y)) * std::max(direction.y(), 0.0) * SolidAngle(image, y);
    }
  }
  for (Eigen::Array3f& pixel : image.pixels) pixel *= static_cast<float>(kPi / irradiance);
  return Environment(std::move(image));
}

Environment Environment::Read(const std::filesystem::path& path) {
  Image image = ReadImage(path);
  if (image.width != 2 * image.height) {
    throw ConfigError(fmt::format("{}: has {} x {} pixels, must be twice as wide as high",
                                  path.string(), image.width, image.height));
  }
  for (const Eigen::Array3f& pixel : image.pixels) {
    if ((pixel < 0).any()) throw ConfigError(path.string() + ": holds negative radiance");
  }
  try {
    return Environment(std::move(image));
  } catch (const ConfigError&) {
    throw ConfigError(path.string() + ": is black");
  }
}

Eigen::Array3f Environment::Radiance(const Eigen::Vector3d& direction) const {
  const Place place = PlaceOf(direction);
  return image_.at(Clip(place.u * image_.width, image_.width),
                   Clip(place.v * image_.height, image_.height));
}

// Uniform over the solid angle of a pixel that is drawn by its share of the light.
Environment::Sample Environment::Draw(double u, double v) const {
  const auto row_end = std::upper_bound(row_cdf_.begin(), row_cdf_.end(), v);
  const int y = Clip(static_cast<double>(row_end - row_cdf_.begin()) - 1, image_.height);
  const double* cdf = column_cdf_.data() + std::size_t(y) * (image_.width + 1);
  const double* column_end = std::upper_bound(cdf, cdf + image_.width + 1, u);
  const int x = Clip(static_cast<double>(column_end - cdf) - 1, image_.width);
  const double along = (u - cdf[x]) / (cdf[x + 1] - cdf[x]);
  const double down = (v - row_cdf_[y]) / (row_cdf_[y + 1] - row_cdf_[y]);
  const double top = std::cos(kPi * y / image_.height);
  const double bottom = std::cos(kPi * (y + 1) / image_.height);
  const double polar = std::acos(std::clamp(top + down * (bottom - top), -1.0, 1.0));
  return {DirectionAt((x + along) / image_.width, polar / kPi),
          Luminance(image_.at(x, y)) / total_};
}

double Environment::Pdf(const Eigen::Vector3d& direction) const {
  return Luminance(Radiance(direction)) / total_;
}

}  // namespace gonio
