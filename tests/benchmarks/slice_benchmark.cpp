// SPDX-License-Identifier: Apache-2.0
// The slices of one material, by each method, on one thread and on two.
#include <benchmark/benchmark.h>

#include "tests/benchmarks/materials.h"
#include "tests/benchmarks/slice_problem.h"

namespace gonio {
namespace {

const SliceProblem& Satin() {
  static const SliceProblem problem(SatinPaint());
  return problem;
}

// items_per_second on two threads over that on one is the speed-up.
template <auto Fit>
void BM_FitSlices(benchmark::State& state) {
  const SliceProblem& problem = Satin();
  for (auto _ : state) benchmark::DoNotOptimize((problem.*Fit)());
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_FitSlices<&SliceProblem::Em>)
    ->ThreadRange(1, 2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(BM_FitSlices<&SliceProblem::Joint>)
    ->ThreadRange(1, 2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(BM_FitSlices<&SliceProblem::Continuous>)
    ->ThreadRange(1, 2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gonio
