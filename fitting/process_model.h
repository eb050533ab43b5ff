// SPDX-License-Identifier: Apache-2.0
// A Gaussian process over reflectance as a linear model with few weights.

#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "brdf/brdf.h"
#include "fitting/process_prior.h"

namespace gonio {

// z = glog(f_r) of the three channels as three series y = T z, each a mean and features times
// weights that are standard normal beforehand:
//
//   y_s(x) = mean_s(x) + features_g(s)(x) . w_s
//
// Series that share their features form a group: luminance, and chroma; features are learned and
// stationary components (fitting/process_prior.h).
//
// Working with weights instead of readings bounds the cost as readings grow in number (Rasmussen &
// Williams, "Gaussian Processes for Machine Learning", 2006, section 2.1). Immutable.
class ProcessModel {
 public:
  struct Group {
    int first_series = 0;
    int series = 1;
    int learned = 0;  // so many features come first; the others are the stationary part
    int size = 0;     // all features
  };
  // What the model says at one direction.
  struct Place {
    std::array<Eigen::VectorXd, kChannels> features;  // one for each group
    Eigen::Vector3d mean;                             // of the series
  };

  explicit ProcessModel(const ProcessPrior& prior);

  const std::vector<Group>& groups() const { return groups_; }
  double floor() const { return floor_; }
  // y = T z; orthonormal.
  const Eigen::Matrix3d& transform() const { return transform_; }
  const std::vector<Calibration>& calibration() const { return calibration_; }
  double error_margin() const { return error_margin_; }

  Place At(const HalfDiff& angles) const;
  // Coefficients of the three series' means where their weights are these: a column for each.
  Eigen::MatrixXd FieldOf(const std::array<Eigen::VectorXd, kChannels>& weights) const;
  Eigen::Vector3d SeriesAt(const HalfDiff& angles, const Eigen::MatrixXd& field) const;

 private:
  double floor_;
  Eigen::Matrix3d transform_;
  std::vector<Group> groups_;
  std::vector<Calibration> calibration_;
  double error_margin_;
  ProcessBasis basis_;
  Eigen::MatrixXd mean_;                     // basis_.size() x 3
  std::vector<Eigen::MatrixXd> components_;  // for each group, basis_.size() x its size
};

}  // namespace gonio
