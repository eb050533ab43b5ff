// SPDX-License-Identifier: Apache-2.0
#include "fitting/slice_joint.h"

#include <ceres/tiny_solver.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/check.h"
#include "fitting/dsbrdf.h"
#include "fitting/hemi_epd.h"

namespace gonio {
namespace {

// Widths of the narrowest lobe that starts try: from a satin gloss to a mirror.
constexpr std::array<double, 5> kNarrowestStarts = {5, 30, 150, 800, 5000};
constexpr int kMaxSteps = 60;

// Sweeps end when no slice's cost falls by more than this share and this much: its unit is half a
// squared model error, so that such falls change nothing that can be seen.
constexpr double kSettledShare = 2e-3;
constexpr double kSettledFall = 0.05;

struct Reading {
  double log_cos;
  double cosine;  // over the floor
  double seen;    // ln(1 + c L / floor)
  double weight;  // square root of w
};

// The smooth version of Huber's loss is r^2 for small r and 2 huber |r| for large: as a residual
// whose square it is, and that residual's slope.
struct Robust {
  double residual;
  double slope;
};
Robust SmoothHuber(double r, double huber) {
  const double q = r / huber;
  const double root = std::sqrt(1 + q * q);
  const double half = std::sqrt(2 / (1 + root));  // sqrt(2 (root - 1)) = |q| sqrt(2 / (1 + root))
  return {r * half, half * (1 - q * q / (2 * root * (1 + root)))};
}

template <int K>
class SliceProblem {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 2 * K };
  using Logs = Eigen::Matrix<double, 2 * K, 1>;  // log kappa, log gamma of each lobe

  SliceProblem(std::span<const SlicePoint> points, const JointOptions& options)
      : options_(options) {
    double total = 0;
    for (const SlicePoint& point : points) {
      if (point.cells == 0) continue;
      const double weight = (point.width > 0 ? point.width : 1) * point.cells;
      const double cosine = point.cos_theta_i / options.floor;
      readings_.push_back(
          {LogCos(point.theta_h), cosine, std::log1p(std::max(cosine * point.f_r, -0.9)), weight});
      total += weight;
    }
    for (Reading& reading : readings_) {
      reading.weight = std::sqrt(reading.weight * static_cast<double>(readings_.size()) / total);
    }
  }

  void set_neighbours(std::vector<Logs> neighbours) { neighbours_ = std::move(neighbours); }

  int NumResiduals() const {
    return static_cast<int>(readings_.size() + 2 * K * neighbours_.size());
  }

  double Cost(const Logs& logs) const {
    Eigen::VectorXd residuals(NumResiduals());
    (*this)(logs.data(), residuals.data(), nullptr);
    return residuals.squaredNorm() / 2;
  }

  bool operator()(const double* logs, double* residuals, double* jacobian) const {
    std::array<BoundedLobe, K> lobes;
    for (int k = 0; k < K; ++k) lobes[k] = BoundedLobe(logs[2 * k], logs[2 * k + 1]);
    const std::size_t rows = NumResiduals();
    for (std::size_t n = 0; n < readings_.size(); ++n) {
      std::array<LobeSlopes, K> slopes;
      double f_r = 0;
      for (int k = 0; k < K; ++k) {
        slopes[k] = lobes[k].Slopes(readings_[n].log_cos);
        f_r += slopes[k].f_r;
      }
      const Reading& at = readings_[n];
      const double shown = 1 + at.cosine * f_r;
      const Robust robust =
          SmoothHuber((at.seen - std::log(shown)) / options_.model_error, options_.huber);
      residuals[n] = at.weight * robust.residual;
      if (jacobian == nullptr) continue;
      const double outer = -at.weight * robust.slope * at.cosine / (shown * options_.model_error);
      for (int k = 0; k < K; ++k) {
        jacobian[2 * k * rows + n] = outer * slopes[k].by_log_kappa;
        jacobian[(2 * k + 1) * rows + n] = outer * slopes[k].by_log_gamma;
      }
    }
    AddCoupling(logs, residuals, jacobian);
    return true;
  }

 private:
  void AddCoupling(const double* logs, double* residuals, double* jacobian) const {
    const std::size_t rows = NumResiduals();
    std::size_t row = readings_.size();
    for (const Logs& neighbour : neighbours_) {
      for (int a = 0; a < 2 * K; ++a, ++row) {
        residuals[row] = (logs[a] - neighbour[a]) / options_.coupling;
        if (jacobian == nullptr) continue;
        for (int b = 0; b < 2 * K; ++b) jacobian[b * rows + row] = 0;
        jacobian[a * rows + row] = 1 / options_.coupling;
      }
    }
  }

  const JointOptions& options_;
  std::vector<Reading> readings_;
  std::vector<Logs> neighbours_;
};

template <int K>
class Chain {
 public:
  using Problem = SliceProblem<K>;
  using Logs = typename Problem::Logs;

  Chain(std::span<const std::vector<SlicePoint>> slices, const JointOptions& options)
      : options_(options) {
    for (const auto& points : slices) {
      problems_.emplace_back(points, options);
      states_.push_back(FitAlone(points, problems_.back()));
    }
  }

  std::vector<SliceFit> Run() {
    const int last = static_cast<int>(states_.size()) - 1;
    bool settled = last == 0;
    for (int sweep = 0; sweep < options_.sweeps && !settled; ++sweep) {
      settled = true;
      for (int i = 0; i <= last; ++i) settled &= Refit(sweep % 2 == 0 ? i : last - i);
    }
    std::vector<SliceFit> fits;
    for (const State& state : states_) fits.push_back(ToFit(state));
    return fits;
  }

 private:
  struct State {
    Logs logs;
    double cost = std::numeric_limits<double>::infinity();
    int iterations = 0;
    bool settled = true;
  };

  State Solve(const Problem& problem, const Logs& start) {
    State state{.logs = start};
    solver_.options.max_num_iterations = kMaxSteps;
    solver_.options.gradient_tolerance = 1e-6;
    solver_.options.parameter_tolerance = 1e-6;
    const auto& summary = solver_.Solve(problem, &state.logs);
    for (int k = 0; k < K; ++k) {
      state.logs.template segment<2>(2 * k) =
          BoundedLobe::Clamp(state.logs.template segment<2>(2 * k));
    }
    if (std::isfinite(summary.final_cost)) state.cost = summary.final_cost;
    state.iterations = summary.iterations;
    return state;
  }

  State FitAlone(std::span<const SlicePoint> points, const Problem& problem) {
    State best;
    for (const double narrowest : kNarrowestStarts) {
      Logs start;
      const std::vector<Lobe> lobes = StartingLobes(points, K, narrowest);
      for (int k = 0; k < K; ++k) {
        start[2 * k] = std::log(lobes[k].kappa);
        start[2 * k + 1] = std::log(lobes[k].gamma);
      }
      State state = Solve(problem, start);
      if (state.cost < best.cost || narrowest == kNarrowestStarts.front()) best = state;
    }
    Sort(&best.logs);
    return best;
  }

  static void Sort(Logs* logs) {
    std::array<Eigen::Vector2d, K> lobes;
    for (int k = 0; k < K; ++k) lobes[k] = logs->template segment<2>(2 * k);
    std::sort(lobes.begin(), lobes.end(), [](const auto& a, const auto& b) { return a[1] < b[1]; });
    for (int k = 0; k < K; ++k) logs->template segment<2>(2 * k) = lobes[k];
  }

  // From where the slice and its neighbours stand. Whether its cost hardly fell.
  bool Refit(int at) {
    std::vector<Logs> neighbours;
    if (at > 0) neighbours.push_back(states_[at - 1].logs);
    if (at + 1 < static_cast<int>(states_.size())) neighbours.push_back(states_[at + 1].logs);
    problems_[at].set_neighbours(neighbours);
    const double before = problems_[at].Cost(states_[at].logs);
    State best = Solve(problems_[at], states_[at].logs);
    for (const Logs& start : neighbours) {
      const State state = Solve(problems_[at], start);
      if (state.cost < best.cost) best = state;
    }
    best.iterations += states_[at].iterations;
    best.settled = before - best.cost < kSettledShare * before + kSettledFall;
    states_[at] = best;
    return best.settled;
  }

  static SliceFit ToFit(const State& state) {
    SliceFit fit;
    for (int k = 0; k < K; ++k) {
      fit.lobes.push_back(BoundedLobe(state.logs[2 * k], state.logs[2 * k + 1]).lobe());
    }
    fit.iterations = state.iterations;
    fit.converged = state.settled;
    fit.cost = state.cost;
    fit.reason = state.settled ? "cost no longer falls" : "limit of sweeps";
    return fit;
  }

  const JointOptions& options_;
  std::vector<Problem> problems_;
  std::vector<State> states_;
  ceres::TinySolver<Problem> solver_;
};

}  // namespace

std::vector<SliceFit> FitSlicesJoint(std::span<const std::vector<SlicePoint>> slices,
                                     const JointOptions& options) {
  static_assert(kMaxLobes == 5, "a case for each number of lobes");
  switch (options.lobes) {
    case 1:
      return Chain<1>(slices, options).Run();
    case 2:
      return Chain<2>(slices, options).Run();
    case 3:
      return Chain<3>(slices, options).Run();
    case 4:
      return Chain<4>(slices, options).Run();
    case 5:
      return Chain<5>(slices, options).Run();
  }
  GONIO_CHECK(false, "1 to 5 lobes");
  return {};
}

}  // namespace gonio
