// SPDX-License-Identifier: Apache-2.0
#include "fitting/slice_em.h"

#include <ceres/tiny_solver.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fitting/hemi_epd.h"

namespace gonio {
namespace {

constexpr double kNarrowestStart = 200;
constexpr int kStepsPerMStep = 20;

struct Reading {
  double log_cos;
  double f_r;
};

// q L - f of one lobe, by log kappa and log gamma: what a M-step minimises the squares of.
struct LobeResiduals {
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 2 };

  const std::vector<Reading>& readings;
  const double* shares;  // q_nk L_n

  int NumResiduals() const { return static_cast<int>(readings.size()); }
  bool operator()(const double* logs, double* residuals, double* jacobian) const {
    const BoundedLobe lobe(logs[0], logs[1]);
    const auto n = readings.size();
    for (std::size_t i = 0; i < n; ++i) {
      const LobeSlopes slopes = lobe.Slopes(readings[i].log_cos);
      residuals[i] = shares[i] - slopes.f_r;
      if (jacobian == nullptr) continue;
      jacobian[i] = -slopes.by_log_kappa;
      jacobian[n + i] = -slopes.by_log_gamma;
    }
    return true;
  }
};

class Em {
 public:
  Em(std::span<const SlicePoint> points, const EmOptions& options) : options_(options) {
    for (const SlicePoint& point : points) {
      if (point.cells > 0) readings_.push_back({LogCos(point.theta_h), point.f_r});
    }
    for (const Lobe& lobe : StartingLobes(points, options.lobes, kNarrowestStart)) {
      logs_.push_back({std::log(lobe.kappa), std::log(lobe.gamma)});
    }
    shares_.resize(Eigen::Index(readings_.size()), options.lobes);
  }

  SliceFit Run() {
    SliceFit fit;
    while (fit.iterations < options_.max_iterations && !fit.converged) {
      ++fit.iterations;
      EStep();
      fit.converged = MStep() < options_.tolerance;
    }
    fit.reason = fit.converged ? "parameters no longer move"
                               : fmt::format("limit of {} iterations", options_.max_iterations);
    for (const auto& logs : logs_) fit.lobes.push_back(BoundedLobe(logs[0], logs[1]).lobe());
    fit.cost = SquaredError(fit.lobes);
    return fit;
  }

 private:
  // The share of each reading that each lobe is held responsible for.
  void EStep() {
    std::vector<Lobe> lobes;
    std::vector<double> log_c;
    for (const auto& logs : logs_) {
      lobes.push_back(BoundedLobe(logs[0], logs[1]).lobe());
      log_c.push_back(-LogHemisphereIntegral(lobes.back()));
    }
    Eigen::ArrayXd log_p(options_.lobes);
    for (std::size_t n = 0; n < readings_.size(); ++n) {
      for (int k = 0; k < options_.lobes; ++k) {
        log_p[k] = log_c[k] + LogLobe(lobes[k], readings_[n].log_cos);
      }
      const Eigen::ArrayXd p = (log_p - log_p.maxCoeff()).exp();
      shares_.row(Eigen::Index(n)) = readings_[n].f_r * p / p.sum();
    }
  }

  // Fits each lobe to its shares; the largest move of a parameter.
  double MStep() {
    double moved = 0;
    for (int k = 0; k < options_.lobes; ++k) {
      const Eigen::Vector2d before = logs_[k];
      const LobeResiduals residuals{readings_, shares_.col(k).data()};
      solver_.options.max_num_iterations = kStepsPerMStep;
      solver_.Solve(residuals, &logs_[k]);
      logs_[k] = BoundedLobe::Clamp(logs_[k]);
      moved = std::max(moved, (logs_[k] - before).cwiseAbs().maxCoeff());
    }
    return moved;
  }

  double SquaredError(const std::vector<Lobe>& lobes) const {
    double sum = 0;
    for (const Reading& reading : readings_) {
      double residual = reading.f_r;
      for (const Lobe& lobe : lobes) residual -= EvalLobe(lobe, reading.log_cos);
      sum += residual * residual;
    }
    return sum;
  }

  const EmOptions& options_;
  std::vector<Reading> readings_;
  std::vector<Eigen::Vector2d> logs_;  // log kappa, log gamma of each lobe
  Eigen::ArrayXXd shares_;             // readings x lobes
  ceres::TinySolver<LobeResiduals> solver_;
};

}  // namespace

SliceFit FitSliceEm(std::span<const SlicePoint> points, const EmOptions& options) {
  return Em(points, options).Run();
}

}  // namespace gonio
