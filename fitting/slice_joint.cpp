// SPDX-License-Identifier: Apache-2.0
#include "fitting/slice_joint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/check.h"
#include "fitting/dsbrdf.h"
#include "fitting/hemi_epd.h"
#include "fitting/levenberg_marquardt.h"

namespace gonio {
namespace {

// Widths of the narrowest lobe that starts try: from a satin gloss to a mirror.
constexpr std::array<double, 5> kNarrowestStarts = {5, 30, 150, 800, 5000};
constexpr int kMaxSteps = 60;
constexpr double kTolerance = 1e-5;

// Sweeps end when no slice's cost falls by more than this share and this much: its unit is half a
// squared model error, so that such falls change nothing that can be seen.
constexpr double kSettledShare = 2e-3;
constexpr double kSettledFall = 0.05;

// One slice's share of the sum, its neighbours held.
template <int K>
class SliceProblem {
 public:
  using Logs = Eigen::Matrix<double, 2 * K, 1>;  // log kappa, log gamma of each lobe
  using Hessian = Eigen::Matrix<double, 2 * K, 2 * K>;

  SliceProblem(std::span<const SlicePoint> points, const JointOptions& options)
      : options_(options) {
    const auto n = std::count_if(points.begin(), points.end(),
                                 [](const SlicePoint& point) { return point.cells > 0; });
    for (Eigen::ArrayXd* column : {&log_cos_, &cosine_, &seen_, &weight_}) column->resize(n);
    Eigen::Index i = 0;
    for (const SlicePoint& point : points) {
      if (point.cells == 0) continue;
      log_cos_[i] = LogCos(point.theta_h);
      cosine_[i] = point.cos_theta_i / options.floor;
      seen_[i] = std::log1p(std::max(cosine_[i] * point.f_r, -0.9));
      weight_[i] = (point.width > 0 ? point.width : 1) * point.cells;
      ++i;
    }
    weight_ /= weight_.mean();
  }

  void set_neighbours(std::vector<Logs> neighbours) { neighbours_ = std::move(neighbours); }

  double Linearise(const Logs& logs, Logs* gradient, Hessian* hessian) const {
    std::array<BoundedLobe::Columns, K> lobes;
    Eigen::ArrayXd shown = Eigen::ArrayXd::Ones(log_cos_.size());
    for (int k = 0; k < K; ++k) {
      BoundedLobe(logs[2 * k], logs[2 * k + 1]).Fill(log_cos_, &lobes[k]);
      shown += cosine_ * lobes[k].col(0);
    }
    // The smooth version of Huber's loss: r^2 / 2 for small r, huber |r| for large.
    const Eigen::ArrayXd r = (seen_ - shown.log()) / options_.model_error;
    const Eigen::ArrayXd root = (1 + (r / options_.huber).square()).sqrt();
    const Eigen::ArrayXd inner = -cosine_ / (shown * options_.model_error);  // dr / df
    const Eigen::ArrayXd pull = weight_ * r / root * inner;
    const Eigen::ArrayXd stiffness = (weight_ / root).sqrt() * inner;
    Eigen::Matrix<double, Eigen::Dynamic, 2 * K> jacobian(r.size(), 2 * K);
    for (int k = 0; k < K; ++k) {
      for (int a = 0; a < 2; ++a) {
        const auto slope = lobes[k].col(1 + a);
        (*gradient)[2 * k + a] = (pull * slope).sum();
        jacobian.col(2 * k + a) = stiffness * slope;
      }
    }
    *hessian = jacobian.transpose().lazyProduct(jacobian);
    const double huber2 = options_.huber * options_.huber;
    return huber2 * (weight_ * (root - 1)).sum() + Coupling(logs, gradient, hessian);
  }

 private:
  double Coupling(const Logs& logs, Logs* gradient, Hessian* hessian) const {
    const double precision = 1 / (options_.coupling * options_.coupling);
    double cost = 0;
    for (const Logs& neighbour : neighbours_) {
      cost += 0.5 * precision * (logs - neighbour).squaredNorm();
      *gradient += precision * (logs - neighbour);
      hessian->diagonal().array() += precision;
    }
    return cost;
  }

  const JointOptions& options_;
  Eigen::ArrayXd log_cos_;
  Eigen::ArrayXd cosine_;  // over the floor
  Eigen::ArrayXd seen_;    // ln(1 + c L / floor)
  Eigen::ArrayXd weight_;
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

  static State Solve(const Problem& problem, const Logs& start) {
    const auto minimum = Minimise(problem, start, kMaxSteps, kTolerance);
    State state{.logs = minimum.parameters, .iterations = minimum.iterations};
    if (std::isfinite(minimum.cost)) state.cost = minimum.cost;
    for (int k = 0; k < K; ++k) {
      state.logs.template segment<2>(2 * k) =
          BoundedLobe::Clamp(state.logs.template segment<2>(2 * k));
    }
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
      if (state.cost < best.cost || !std::isfinite(best.cost)) best = state;
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
    Logs gradient;
    typename Problem::Hessian hessian;
    const double before = problems_[at].Linearise(states_[at].logs, &gradient, &hessian);
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
