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

// q L - f of one lobe, by log kappa and log gamma: what a M-step minimises the squares of.
struct LobeResiduals {
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 2 };

  const Eigen::ArrayXd& log_cos;
  const Eigen::ArrayXd& shares;  // q_nk L_n

  int NumResiduals() const { return static_cast<int>(log_cos.size()); }
  bool operator()(const double* logs, double* residuals, double* jacobian) const {
    const Eigen::Index n = log_cos.size();
    BoundedLobe(logs[0], logs[1]).Fill(log_cos, &columns);
    Eigen::Map<Eigen::ArrayXd>(residuals, n) = shares - columns.col(0);
    if (jacobian != nullptr) Eigen::Map<Eigen::ArrayXXd>(jacobian, n, 2) = -columns.rightCols(2);
    return true;
  }

  mutable BoundedLobe::Columns columns{};  // kept to save allocating it each time
};

class Em {
 public:
  Em(std::span<const SlicePoint> points, const EmOptions& options) : options_(options) {
    const auto n = std::count_if(points.begin(), points.end(),
                                 [](const SlicePoint& point) { return point.cells > 0; });
    log_cos_.resize(n);
    f_r_.resize(n);
    Eigen::Index i = 0;
    for (const SlicePoint& point : points) {
      if (point.cells == 0) continue;
      log_cos_[i] = LogCos(point.theta_h);
      f_r_[i++] = point.f_r;
    }
    for (const Lobe& lobe : StartingLobes(points, options.lobes, kNarrowestStart)) {
      logs_.push_back({std::log(lobe.kappa), std::log(lobe.gamma)});
    }
    shares_.assign(options.lobes, Eigen::ArrayXd(n));
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
    for (Eigen::Index n = 0; n < f_r_.size(); ++n) {
      for (int k = 0; k < options_.lobes; ++k) {
        log_p[k] = log_c[k] + LogLobe(lobes[k], log_cos_[n]);
      }
      const Eigen::ArrayXd p = (log_p - log_p.maxCoeff()).exp();
      for (int k = 0; k < options_.lobes; ++k) shares_[k][n] = f_r_[n] * p[k] / p.sum();
    }
  }

  // Fits each lobe to its shares; the largest move of a parameter.
  double MStep() {
    double moved = 0;
    for (int k = 0; k < options_.lobes; ++k) {
      const Eigen::Vector2d before = logs_[k];
      const LobeResiduals residuals{log_cos_, shares_[k]};
      solver_.options.max_num_iterations = kStepsPerMStep;
      solver_.Solve(residuals, &logs_[k]);
      logs_[k] = BoundedLobe::Clamp(logs_[k]);
      moved = std::max(moved, (logs_[k] - before).cwiseAbs().maxCoeff());
    }
    return moved;
  }

  double SquaredError(const std::vector<Lobe>& lobes) const {
    double sum = 0;
    for (Eigen::Index n = 0; n < f_r_.size(); ++n) {
      double residual = f_r_[n];
      for (const Lobe& lobe : lobes) residual -= EvalLobe(lobe, log_cos_[n]);
      sum += residual * residual;
    }
    return sum;
  }

  const EmOptions& options_;
  Eigen::ArrayXd log_cos_, f_r_;        // of the readings
  std::vector<Eigen::Vector2d> logs_;   // log kappa, log gamma of each lobe
  std::vector<Eigen::ArrayXd> shares_;  // of each lobe in each reading
  ceres::TinySolver<LobeResiduals> solver_;
};

}  // namespace

SliceFit FitSliceEm(std::span<const SlicePoint> points, const EmOptions& options) {
  return Em(points, options).Run();
}

}  // namespace gonio
