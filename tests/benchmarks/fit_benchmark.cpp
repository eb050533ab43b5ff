// SPDX-License-Identifier: Apache-2.0
// Fits: of a whole table, and against Ceres.
#include <benchmark/benchmark.h>

#include "fitting/fit.h"
#include "fitting/posterior.h"
#include "fitting/starts.h"
#include "tests/benchmarks/materials.h"
#include "tests/fitting/ceres_posterior.h"

namespace gonio {
namespace {

// A 90 x 90 x 3 table, from the readings to the fit with its covariance.
void BM_DenseFit(benchmark::State& state) {
  const std::vector<BrdfSample>& samples = DenseReadings();
  const Prior prior = GenericPrior();
  FitSummary summary;
  for (auto _ : state) summary = FitDsbrdf(samples, prior).summary();
  state.counters["iterations"] = summary.iterations;
  state.counters["converged"] = summary.converged;
}
BENCHMARK(BM_DenseFit)->Unit(benchmark::kMillisecond);

// The same posterior minimised from the same start to the same tolerance: 0, ours; 1, Ceres with
// DENSE_NORMAL_CHOLESKY and analytic Jacobians. Setting the problem up counts on both sides.
void BM_DenseFitGaussNewtonVsCeres(benchmark::State& state) {
  const bool ceres = state.range(0) == 1;
  const std::vector<BrdfSample>& samples = DenseReadings();
  const Prior prior = GenericPrior();
  const FitOptions options;
  const PosteriorOptions same{options.floor, options.huber, options.model_error};
  const Eigen::VectorXd start = FitStarts(samples, prior)[2];
  double cost = 0;
  int iterations = 0;
  for (auto _ : state) {
    if (ceres) {
      const CeresMinimum minimum =
          MinimiseWithCeres(samples, prior, same, start, options.max_iterations, options.tolerance);
      cost = minimum.cost;
      iterations = minimum.iterations;
    } else {
      const DsbrdfFit fit = RefitDsbrdf(samples, prior, options, start, options.model_error);
      cost = fit.summary().cost;
      iterations = fit.summary().iterations;
    }
  }
  state.SetLabel(ceres ? "Ceres" : "ours");
  state.counters["cost"] = cost;
  state.counters["iterations"] = iterations;
  state.counters["per_iteration"] = benchmark::Counter(
      iterations, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(BM_DenseFitGaussNewtonVsCeres)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

// A hundred scattered poses, all starts.
void BM_Fit100(benchmark::State& state) {
  std::vector<BrdfSample> samples;
  for (std::size_t i = 0; i < 100; ++i) samples.push_back(DenseReadings()[i * 79]);
  const Prior prior = GenericPrior();
  for (auto _ : state) benchmark::DoNotOptimize(FitDsbrdf(samples, prior));
}
BENCHMARK(BM_Fit100)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gonio
