// SPDX-License-Identifier: Apache-2.0
#include "fitting/scattered_reflectance.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/check.h"
#include "core/units.h"
#include "fitting/grid_reflectance.h"

namespace gonio {
namespace {

constexpr double kTogether = 1e-9;  // keeps two readings of one direction apart

// Where a direction lies in the plane that is interpolated over.
Eigen::Vector2d Place(const HalfDiff& angles, double stretch) {
  return {std::sqrt(angles.theta_h / (kPi / 2)), stretch * angles.theta_d / (kPi / 2)};
}

// One channel's interpolant.
class Interpolant {
 public:
  Interpolant(std::span<const BrdfSample> samples, int channel, const ScatteredOptions& options)
      : options_(options) {
    for (const BrdfSample& sample : samples) {
      const double sigma = sample.sigma[channel];
      const double f_r = sample.f_r[channel];
      if (!std::isfinite(sigma) || !std::isfinite(f_r)) continue;
      places_.push_back(Place(ToHalfDiff(sample.directions), options.stretch));
      const double above = std::max(f_r, 0.0) + options.floor;
      log_f_r_.push_back(std::log(above));
      // A reading's variance against the unit slope of the kernel.
      smoothing_.push_back(kTogether + options.smoothing * std::pow(sigma / above, 2));
    }
    if (!places_.empty()) Solve();
  }

  double operator()(const HalfDiff& angles) const {
    if (places_.empty()) return 0;
    const Eigen::Vector2d place = Place(angles, options_.stretch);
    const Eigen::Index count = weights_.size() - 1;
    double sum = weights_[count];
    for (Eigen::Index n = 0; n < count; ++n) sum -= weights_[n] * (place - places_[n]).norm();
    return std::exp(std::clamp(sum, low_, high_)) - options_.floor;
  }

 private:
  // [-D + smoothing, 1; 1', 0] [w; a] = [y; 0]: -D is positive definite where the weights sum to 0.
  void Solve() {
    const auto count = static_cast<Eigen::Index>(places_.size());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count + 1, count + 1);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(count + 1);
    for (Eigen::Index i = 0; i < count; ++i) {
      for (Eigen::Index j = 0; j < i; ++j) {
        matrix(i, j) = matrix(j, i) = -(places_[i] - places_[j]).norm();
      }
      matrix(i, i) = smoothing_[i];
      matrix(i, count) = matrix(count, i) = 1;
      right[i] = log_f_r_[i];
    }
    weights_ = matrix.partialPivLu().solve(right);
    const auto [low, high] = std::minmax_element(log_f_r_.begin(), log_f_r_.end());
    low_ = *low;
    high_ = *high;
  }

  ScatteredOptions options_;
  std::vector<Eigen::Vector2d> places_;
  std::vector<double> log_f_r_, smoothing_;
  Eigen::VectorXd weights_;  // one for each reading, then the constant
  double low_ = 0, high_ = 0;
};

}  // namespace

std::unique_ptr<Brdf> InterpolateScattered(std::span<const BrdfSample> samples,
                                           const ScatteredOptions& options) {
  GONIO_CHECK(options.floor > 0 && options.stretch > 0 && options.smoothing >= 0,
              "options are in range");
  const AngleGrid grid(90, 46, 1);
  Eigen::Matrix3Xf f_r(kChannels, grid.size());
  for (int c = 0; c < kChannels; ++c) {
    const Interpolant interpolant(samples, c, options);
    for (int node = 0; node < grid.size(); ++node) {
      f_r(c, node) = static_cast<float>(std::max(interpolant(grid.Node(node)), 0.0));
    }
  }
  return std::make_unique<GridReflectance>("interpolated", grid, f_r);
}

}  // namespace gonio
