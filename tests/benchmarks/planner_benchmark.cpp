// SPDX-License-Identifier: Apache-2.0
// One step of the information planner with 8,100 candidates.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "core/units.h"
#include "fitting/prior.h"
#include "fitting/process_fit.h"
#include "planner/information_planner.h"
#include "planner/process_gain.h"
#include "tests/benchmarks/materials.h"

namespace gonio {
namespace {

InformationOptions Options() {
  InformationOptions options;
  options.max_poses = 100000;
  options.min_gain = 0;
  options.prior = GenericPrior();
  return options;
}

void BM_Score8100(benchmark::State& state) {
  std::vector<BrdfSample> samples;
  std::vector<int> measured;
  for (int i = 0; i < 100; ++i) {
    measured.push_back(i * 79);
    samples.push_back(DenseReadings()[static_cast<std::size_t>(i) * 79]);
  }
  const DsbrdfFit fit = FitDsbrdf(samples, GenericPrior());
  const InformationGain gain(MakeCandidates({}, {}), {});
  for (auto _ : state) benchmark::DoNotOptimize(gain.Evaluate(fit, measured));
}
BENCHMARK(BM_Score8100)->Unit(benchmark::kMillisecond);

// Observe() and Next(), refit included, with that many samples and the ones after. The mean holds
// the rare steps at which all starts are tried again; max is the longest single step seen.
void BM_PlanStep(benchmark::State& state) {
  Random random(1, 0);
  InformationPlanner planner(MakeCandidates({}, {}), Options());
  std::optional<Proposal> next = planner.Next();
  const auto answer = [&] {
    planner.Observe(*next, Reading(next->directions, random));
    next = planner.Next();
  };
  for (int n = 0; n < state.range(0); ++n) answer();
  double longest = 0;
  for (auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    answer();
    const std::chrono::duration<double> step = std::chrono::steady_clock::now() - begin;
    longest = std::max(longest, step.count());
  }
  state.counters["max_ms"] = 1000 * longest;
}
// A fixed number of steps: the planner learns as it goes, so more steps would be other steps.
BENCHMARK(BM_PlanStep)->Arg(20)->Arg(100)->Iterations(20)->Unit(benchmark::kMillisecond);

// One step with the shipped learned prior after that many readings: refit, score 8,100 candidates
// with four phi_d each, look for the best rate and, with that for the worth of a second, choose.
void BM_LearnedPlanStep(benchmark::State& state) {
  const Prior prior = ReadPrior(GONIO_SOURCE_DIR "/configs/prior-measured.yaml");
  const auto model = std::make_shared<const ProcessModel>(*prior.process);
  std::vector<ProcessReading> readings;
  const std::size_t apart = DenseReadings().size() / static_cast<std::size_t>(state.range(0));
  for (std::size_t n = 0; n < static_cast<std::size_t>(state.range(0)); ++n) {
    readings.push_back(ToReading(*model, DenseReadings()[n * apart]));
  }
  const ProcessOptions options;
  ProcessGain gain(MakeCandidates({.phi_choices = 4, .phi_span = kPi}, {}), {});
  gain.Learn(model, ProcessPosterior(*model, readings, options), options);
  const std::vector<bool> spent(gain.candidates().size(), false);
  for (auto _ : state) {
    gain.Learn(model, ProcessPosterior(*model, readings, options), options);
    const auto rate = [](const Candidate& c, double g) { return g / (1 + 0.1 * c.row); };
    const double second = 0.5 * gain.Best(spent, rate).score;
    const auto net = [&](const Candidate& c, double g) { return g - second * (1 + 0.1 * c.row); };
    benchmark::DoNotOptimize(gain.Best(spent, net));
  }
}
BENCHMARK(BM_LearnedPlanStep)->Arg(20)->Arg(200)->Arg(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gonio
