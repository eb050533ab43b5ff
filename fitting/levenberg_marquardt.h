// SPDX-License-Identifier: Apache-2.0
// The one minimiser of sums of squares and their like.

#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gonio {

// Where a minimisation ended, with the Hessian there. N: how many parameters, or Eigen::Dynamic.
template <int N>
struct Minimum {
  Eigen::Matrix<double, N, 1> parameters;
  Eigen::Matrix<double, N, N> hessian;
  double cost = std::numeric_limits<double>::infinity();
  int iterations = 0;
  bool converged = false;
};

// Diagonal elements of the damped Hessian are at least this share of the largest.
inline constexpr double kLeastShare = 1e-14;

// Levenberg-Marquardt with Marquardt's scaling; gain-ratio damping after Nielsen, "Damping
// Parameter in Marquardt's Method" (1999). `problem` has
//
//   double Linearise(const Vector& at, Vector* gradient, Matrix* hessian) const;
//
// which returns the cost, >= 0, and fills in its gradient and the Gauss-Newton approximation of its
// Hessian. Where that is much dearer than the cost alone it may also have `double Cost(at) const`,
// which steps are then tried with. Converged when a step's fall of the cost, and what it promised,
// are below `tolerance` times (1 + cost); otherwise ended after `max_iterations` steps, tried ones
// included.
template <int N, typename Problem>
Minimum<N> Minimise(const Problem& problem, const Eigen::Matrix<double, N, 1>& start,
                    int max_iterations, double tolerance) {
  Minimum<N> now{.parameters = start, .hessian = {}};
  Eigen::Matrix<double, N, 1> gradient, next_gradient;
  Eigen::Matrix<double, N, N> next_hessian;
  now.cost = problem.Linearise(now.parameters, &gradient, &now.hessian);
  double damping = 1e-3;
  double growth = 2;
  while (now.iterations < max_iterations && !now.converged) {
    ++now.iterations;
    Eigen::Matrix<double, N, N> damped = now.hessian;
    damped.diagonal() *= 1 + damping;
    // A parameter that nothing depends on, as of a lobe that has vanished, stays where it is.
    damped.diagonal() = damped.diagonal().cwiseMax(kLeastShare * damped.diagonal().maxCoeff());
    const Eigen::Matrix<double, N, 1> step = damped.llt().solve(-gradient);
    const double expected = -0.5 * step.dot(gradient) +
                            0.5 * damping * step.dot(now.hessian.diagonal().cwiseProduct(step));
    const Eigen::Matrix<double, N, 1> next = now.parameters + step;
    double cost = 0;
    if constexpr (requires { problem.Cost(next); }) {
      cost = problem.Cost(next);
    } else {
      cost = problem.Linearise(next, &next_gradient, &next_hessian);
    }
    const double fall = now.cost - cost;
    if (!(fall > 0 && next.allFinite())) {
      now.converged = expected < tolerance * (1 + now.cost) || damping > 1e10;
      damping *= growth;
      growth *= 2;
      continue;
    }
    // A step that overshot may fall by next to nothing far from the minimum: expected tells.
    const double enough = tolerance * (1 + now.cost);
    now.converged = fall < enough && expected < 10 * enough;
    if constexpr (requires { problem.Cost(next); }) {
      cost = problem.Linearise(next, &next_gradient, &next_hessian);
    }
    now.parameters = next;
    now.cost = cost;
    gradient.swap(next_gradient);
    now.hessian.swap(next_hessian);
    damping *= std::max(1.0 / 3, 1 - std::pow(2 * fall / expected - 1, 3));
    growth = 2;
  }
  return now;
}

}  // namespace gonio
