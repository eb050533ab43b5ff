// SPDX-License-Identifier: Apache-2.0
// Light from all around.

#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "brdf/render/image.h"

namespace gonio {

// Radiance from infinitely far away, as an equirectangular image: up is +y at the top row, the
// centre column lies in -z behind the sphere as the camera looks at it, +x is to the right.
// Directions point from the scene to the light.
class Environment {
 public:
  // Radiance is constant within a pixel. Throws ConfigError if the image is black.
  explicit Environment(Image image);

  // The built-in clear sky (docs/rendering.md says how it is made): a sun, a sky that is brighter
  // near sun and horizon, dim ground.
  static Environment Sky();
  // A .hdr or .exr that is twice as wide as high. Throws ConfigError "PATH: ...".
  static Environment Read(const std::filesystem::path& path);

  Eigen::Array3f Radiance(const Eigen::Vector3d& direction) const;

  // A direction drawn with density proportional to the luminance per solid angle, from two numbers
  // in [0, 1).
  struct Sample {
    Eigen::Vector3d direction;
    double pdf = 0;  // per steradian
  };
  Sample Draw(double u, double v) const;
  double Pdf(const Eigen::Vector3d& direction) const;

 private:
  Image image_;
  std::vector<double> row_cdf_;     // height + 1
  std::vector<double> column_cdf_;  // height x (width + 1)
  double total_ = 0;                // luminance integrated over all directions
};

}  // namespace gonio
