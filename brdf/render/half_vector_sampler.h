// SPDX-License-Identifier: Apache-2.0
// Half vectors where a material reflects most.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "brdf/brdf.h"

namespace gonio {

// Draws half vectors with a density of theta_h that follows the material: its mean over some
// theta_d, cell by cell of a MERL table's theta_h. A mirror's are near the normal, a cloth's all
// over.
class HalfVectorSampler {
 public:
  explicit HalfVectorSampler(const Brdf& brdf);

  // In the frame of the surface (z its normal), from two numbers in [0, 1).
  Eigen::Vector3d Draw(double u, double v) const;
  // Density per steradian of half vectors. That of the directions wi which wo is mirrored to is a
  // (4 wo.h)th of it.
  double Pdf(const Eigen::Vector3d& half) const;

 private:
  std::vector<double> cdf_;      // over the cells of theta_h
  std::vector<double> density_;  // 1/sr, of each
};

}  // namespace gonio
