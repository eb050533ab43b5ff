// SPDX-License-Identifier: Apache-2.0
// gonio_scipy_problem MATERIAL REPETITIONS: fits a material's slices by each method,
// single-threaded, and prints the problems, the costs reached and the seconds taken as JSON: what
// tests/benchmarks/against_scipy.py gives to SciPy.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>

#include "fitting/hemi_epd.h"
#include "fitting/spline.h"
#include "tests/benchmarks/slice_problem.h"

namespace gonio {
namespace {

using nlohmann::json;

// Calls `fit` so many times; the least seconds that it took.
template <typename Fit>
double LeastSeconds(int repetitions, const Fit& fit) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repetitions; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    fit();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    least = std::min(least, took.count());
  }
  return least;
}

json ToJson(const Eigen::VectorXd& numbers) {
  return std::vector<double>(numbers.begin(), numbers.end());
}

json ToJson(const SliceProblem& problem) {
  json channels = json::array();
  for (const auto& channel : problem.points) {
    json slices = json::array();
    for (const auto& points : channel) {
      json list = json::array();
      for (const SlicePoint& p : points) {
        if (p.cells > 0) list.push_back({p.theta_h, p.f_r, p.cos_theta_i, p.width * p.cells});
      }
      slices.push_back(list);
    }
    channels.push_back(slices);
  }
  return channels;
}

json ContinuousJson(const SliceProblem& problem) {
  json readings = json::array();
  for (const BrdfSample& sample : problem.samples) {
    const HalfDiff angles = ToHalfDiff(sample.directions);
    const SplineBasis basis = BasisAt(angles.theta_d, problem.prior.shape.knots);
    for (int c = 0; c < kChannels; ++c) {
      if (!std::isfinite(sample.sigma[c])) continue;
      readings.push_back(
          {c, basis.first, basis.weight, LogCos(angles.theta_h), sample.f_r[c], sample.sigma[c]});
    }
  }
  json covariance = json::array();
  for (Eigen::Index i = 0; i < problem.prior.mean.size(); ++i) {
    covariance.push_back(ToJson(Eigen::VectorXd(problem.prior.covariance.row(i))));
  }
  const FitOptions& options = problem.continuous;
  return {{"readings", readings},
          {"mean", ToJson(problem.prior.mean)},
          {"covariance", covariance},
          {"start", ToJson(problem.start)},
          {"knots", problem.prior.shape.knots},
          {"floor", options.floor},
          {"huber", options.huber},
          {"model_error", options.model_error},
          {"tolerance", options.tolerance}};
}

double TotalCost(const std::vector<SliceFit>& fits) {
  double cost = 0;
  for (const SliceFit& fit : fits) cost += fit.cost;
  return cost;
}

int Main(const std::string& material, int repetitions) {
  const SliceProblem problem(*OpenBrdf(material));
  json ours;
  ours["em"] = {{"cost", TotalCost(problem.Em())},
                {"seconds", LeastSeconds(repetitions, [&] { problem.Em(); })}};
  ours["joint"] = {{"cost", TotalCost(problem.Joint())},
                   {"seconds", LeastSeconds(repetitions, [&] { problem.Joint(); })}};
  ours["continuous"] = {{"cost", problem.Continuous().cost},
                        {"seconds", LeastSeconds(repetitions, [&] { problem.Continuous(); })}};
  const JointOptions& joint = problem.joint;
  std::cout << json{{"lobes", problem.em.lobes},
                    {"slices", ToJson(problem)},
                    {"em",
                     {{"max_iterations", problem.em.max_iterations},
                      {"tolerance", problem.em.tolerance}}},
                    {"joint",
                     {{"floor", joint.floor},
                      {"model_error", joint.model_error},
                      {"coupling", joint.coupling},
                      {"huber", joint.huber},
                      {"sweeps", joint.sweeps}}},
                    {"continuous", ContinuousJson(problem)},
                    {"ours", ours}}
            << '\n';
  return 0;
}

}  // namespace
}  // namespace gonio

int main(int argc, char** argv) {
  if (argc != 3 || std::atoi(argv[2]) < 1) {
    std::cerr << "usage: gonio_scipy_problem MATERIAL REPETITIONS\n";
    return 2;
  }
  try {
    return gonio::Main(argv[1], std::atoi(argv[2]));
  } catch (const std::exception& e) {
    std::cerr << "gonio_scipy_problem: " << e.what() << '\n';
    return 2;
  }
}
