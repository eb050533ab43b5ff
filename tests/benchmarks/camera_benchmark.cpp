// SPDX-License-Identifier: Apache-2.0
// Frames of 512 x 512 pixels from the GigE Vision double, over loopback:
//
//   build/release/bin/gonio_camera_benchmarks
//
// BM_Capture: one software trigger and its frame (items per second: frames per second). BM_Idle:
// seconds of CPU that an armed camera and its double take per second without a trigger, as
// `cpu_share`.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <chrono>
#include <thread>

#include "drivers/genicam_camera.h"
#include "sim/gige_camera.h"
#include "tests/genicam/own_network.h"

namespace gonio {
namespace {

constexpr const char* kFormats[] = {"Mono12", "Mono16", "Mono12p"};

struct Bench {
  explicit Bench(const char* format) {
    auto served = GigeCamera::Serve({}, [](const GigeExposure&, std::vector<std::uint16_t>&) {});
    if (!served) return;
    device = std::move(served).value();
    GenicamSettings settings;
    settings.name = "camera";
    settings.address = "127.0.0.1";
    settings.pixel_format = format;
    settings.width = settings.height = 512;
    settings.packet_size = 9000;
    auto opened = GenicamCamera::Open(settings, clock);
    if (opened) camera = std::move(opened).value();
  }
  SystemClock clock;
  std::unique_ptr<GigeCamera> device;
  std::unique_ptr<GenicamCamera> camera;
};

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_utime.tv_sec + usage.ru_stime.tv_sec +
         1e-6 * (usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

void BM_Capture(benchmark::State& state) {
  const char* format = kFormats[state.range(0)];
  state.SetLabel(format);
  Bench bench(format);
  if (!bench.camera) return state.SkipWithError("no camera");
  for (auto _ : state) {
    const auto frame = bench.camera->Capture(Seconds(100e-6), {});
    if (!frame) return state.SkipWithError(frame.error().message.c_str());
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["retries"] = bench.camera->counters().retries;
}
BENCHMARK(BM_Capture)->DenseRange(0, 2)->UseRealTime()->Unit(benchmark::kMillisecond);

void BM_Idle(benchmark::State& state) {
  Bench bench("Mono16");
  if (!bench.camera || !bench.camera->Capture(Seconds(100e-6), {})) {
    return state.SkipWithError("no camera");
  }
  const double before = CpuSeconds();
  const auto start = std::chrono::steady_clock::now();
  for (auto _ : state) std::this_thread::sleep_for(std::chrono::seconds(3));
  const Seconds elapsed = std::chrono::steady_clock::now() - start;
  state.counters["cpu_share"] = (CpuSeconds() - before) / elapsed.count();
}
BENCHMARK(BM_Idle)->Iterations(1)->UseRealTime()->Unit(benchmark::kSecond);

}  // namespace
}  // namespace gonio

int main(int argc, char** argv) {
  gonio::EnterOwnNetwork();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
