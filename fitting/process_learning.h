// SPDX-License-Identifier: Apache-2.0
// From materials to the components of a process: sampling, projecting, principal components.

#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "fitting/process_prior.h"
#include "fitting/training.h"

namespace gonio {

// A material in the basis: z = glog(scale f_r), a column for each channel and each of kScales. The
// scaled copies stand for the darker and brighter materials of the same make that no database has.
struct MaterialField {
  static constexpr double kScales[] = {1, 0.5, 2};
  std::string name;
  Eigen::MatrixXd coefficients;  // basis.size() x 3 per scale
};

// Directions a material is read at: a raster, its rows as dense towards the mirror direction as a
// MERL table's. Each > 0.
struct ReadingRaster {
  int theta_h = 90;
  int theta_d = 45;
  int phi_d = 12;
};

// Projects materials onto a basis by weighted least squares, with a little smoothness where nothing
// is known, such as below the horizon.
class FieldSampler {
 public:
  FieldSampler(const ProcessBasis& basis, double floor, const ReadingRaster& raster = {});

  // Throws ConfigError if the material knows less than half of the directions.
  MaterialField Sample(const TrainingMaterial& material) const;
  // Inner product of two coefficient vectors: the mean product of the functions over directions.
  const Eigen::MatrixXd& metric() const { return metric_; }

 private:
  struct Point {
    HalfDiff angles;
    double weight;
  };

  ProcessBasis basis_;
  double floor_;
  std::vector<Point> points_;
  Eigen::MatrixXd metric_;
  Eigen::MatrixXd smoothness_;
};

struct ComponentCounts {
  int luminance = 50;
  int chroma = 40;
};

// Mean and principal components of the fields, and the stationary part's spread: the root mean
// square of what is left of a field where components of others (of other folds) are fitted to it.
// Precondition: at least two.
ProcessPrior LearnProcess(std::span<const MaterialField* const> fields, const ProcessBasis& basis,
                          double floor, const Eigen::MatrixXd& metric,
                          const ComponentCounts& counts);

}  // namespace gonio
