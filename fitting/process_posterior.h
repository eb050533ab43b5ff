// SPDX-License-Identifier: Apache-2.0
// A process after readings: what is known of its weights.

#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "brdf/brdf.h"
#include "fitting/process_model.h"

namespace gonio {

struct ProcessOptions {
  // Standard deviations of log f_r beyond the samples' own sigma, each >= 0: of what no process so
  // smooth can follow (one channel at a time), and of what all channels of a pose share, such as
  // the repeatability of the arms.
  double model_error = 0.03;
  double repeatability = 0.004;
  double huber = 3;         // > 0: readings off by more standard deviations count less
  double scale_weight = 8;  // >= 0: how many readings the process's own scale is worth
  std::vector<double> stationary_scales = {0.35, 0.7, 1.4, 2.8};  // > 0, tried against each other

  // Throws ConfigError naming the option.
  void Check() const;
};

// A sample as the posterior uses it.
struct ProcessReading {
  ProcessModel::Place place;
  Rgb f_r = Rgb::Zero();
  Rgb sigma = Rgb::Zero();  // infinite: this channel is missing
};

// Gaussian posterior of the weights. The noise of a reading's series is
//
//   variance = mean over channels of (sigma glog'(f_r))^2 + model_error^2   (+ 3 repeatability^2
//              for the series that all channels share)
//
// with f_r as the posterior itself predicts it once it can, and Huber's weights against outliers.
// How strong the stationary part is, is chosen by the evidence; an overall scale of the covariance
// is then estimated from how well readings were foretold, as a Student process does (Shah, Wilson &
// Ghahramani, "Student-t Processes as Alternatives to Gaussian Processes", 2014).
class ProcessPosterior {
 public:
  // What is known of one group's weights.
  struct Knowledge {
    Eigen::MatrixXd covariance;  // of each series, the estimated scale included
    double stationary_scale = 1;
    double scale = 1;  // the estimated scale of variances
  };

  ProcessPosterior(const ProcessModel& model, std::span<const ProcessReading> readings,
                   const ProcessOptions& options);

  const std::array<Eigen::VectorXd, kChannels>& weights() const { return weights_; }
  const std::vector<Knowledge>& groups() const { return groups_; }

  // Mean of the three channels' z at a place, and the variance of the three series there, without
  // model error.
  Eigen::Vector3d Mean(const ProcessModel::Place& place) const;
  Eigen::Vector3d SeriesVariance(const ProcessModel::Place& place) const;

 private:
  struct Problem;

  // `last`: the covariance is wanted, too, not just the weights.
  void SolveGroup(int group, const std::vector<Problem>& problems, const ProcessOptions& options,
                  bool last);

  const ProcessModel& model_;
  std::array<Eigen::VectorXd, kChannels> weights_;
  std::vector<Knowledge> groups_;
};

}  // namespace gonio
