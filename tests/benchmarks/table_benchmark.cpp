// SPDX-License-Identifier: Apache-2.0
// MERL tables.
#include <benchmark/benchmark.h>

#include "brdf/merl_table.h"
#include "tests/benchmarks/materials.h"

namespace gonio {
namespace {

// A table in the page cache: 0, opened; 1, opened and every cell read once.
void BM_LoadMerl(benchmark::State& state) {
  const ScratchFolder folder;
  const std::filesystem::path path = folder / "table.binary";
  MerlTable::FromFunction("table", [](const HalfDiff& angles) {
    return std::optional<Rgb>(Rgb::Constant(0.1 + angles.theta_d));
  }).Write(path);
  const bool every_cell = state.range(0) == 1;
  for (auto _ : state) {
    const MerlTable table = MerlTable::Open(path);
    int valid = table.Cell(0, 0, 0) ? 1 : 0;
    for (int h = 0; every_cell && h < MerlTable::kThetaH; ++h) {
      for (int d = 0; d < MerlTable::kThetaD; ++d) {
        for (int p = 0; p < MerlTable::kPhiD; ++p) valid += table.Cell(h, d, p) ? 1 : 0;
      }
    }
    benchmark::DoNotOptimize(valid);
  }
  state.SetLabel(every_cell ? "open and read every cell" : "open");
}
BENCHMARK(BM_LoadMerl)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gonio
