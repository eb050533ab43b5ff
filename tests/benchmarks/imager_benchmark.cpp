// SPDX-License-Identifier: Apache-2.0
// Frames of the simulated camera, 512 by 512 pixels.
#include <benchmark/benchmark.h>

#include "brdf/analytic.h"
#include "core/units.h"
#include "sim/sim_imager.h"

namespace gonio {
namespace {

constexpr int kSide = 512;

Imaging ImagingOf(SampleShape::Kind kind) {
  // A field of 7 deg; the sphere's diameter is 400 pixels.
  return {.focal_length = 4000,
          .camera_distance = 0.5,
          .light_distance = 0.5,
          .shape = {kind, kind == SampleShape::Kind::kFlat ? 0 : 0.025}};
}

SimView View(PixelLayout layout) {
  return {.arms = {0, RadFromDeg(50), kPi, RadFromDeg(60)},
          .power = 1,
          .readout = {.exposure = Seconds(0.1), .black_level = 64, .layout = layout}};
}

// The kind of the shape; the layout.
void BM_Frame(benchmark::State& state) {
  SimConfig truth;
  truth.responsivity = Rgb(1e5, 1.2e5, 8e4);
  truth.electrons_per_count = 4;
  truth.shot_noise = true;
  truth.read_noise = 8;
  truth.dark_current = 5;
  truth.prnu = 0.01;
  truth.dsnu = 2;
  truth.hot_pixels = 1e-3;
  truth.hot_dark_current = 500;
  truth.nonlinearity = 0.01;
  truth.vignetting = 1;
  truth.defocus = static_cast<double>(state.range(2));
  truth.sample_radius = 0.02;
  const AnalyticBrdf satin(
      "satin", {OrenNayar{Rgb(0.1, 0.3, 0.25), 0.4}, Ggx{.roughness = 0.15, .ior = 1.5}});
  SimImager imager(truth, ImagingOf(static_cast<SampleShape::Kind>(state.range(0))), kSide, kSide,
                   Random(1, 1));
  const SimView view = View(static_cast<PixelLayout>(state.range(1)));
  for (auto _ : state) benchmark::DoNotOptimize(imager.Expose(view, satin));
}
BENCHMARK(BM_Frame)
    ->ArgNames({"shape", "layout", "blur"})
    ->Args({0, 0, 0})
    ->Args({0, 2, 0})
    ->Args({0, 2, 1})
    ->Args({1, 0, 0})
    ->Args({1, 2, 0})
    ->Args({1, 2, 1})
    ->Args({2, 2, 0})
    ->Unit(benchmark::kMillisecond);

// Its parts: 0, the image; 1, noise on a bright frame; 2, noise on a dark one.
void BM_FramePart(benchmark::State& state) {
  SimConfig truth;
  truth.responsivity = Rgb::Constant(1e5);
  truth.electrons_per_count = 4;
  truth.shot_noise = true;
  truth.read_noise = 8;
  truth.dark_current = 5;
  const AnalyticBrdf grey("grey", {Lambert{}});
  SimImager imager(truth, ImagingOf(SampleShape::Kind::kFlat), kSide, kSide, Random(1, 1));
  SimView view = View(PixelLayout::kMono);
  view.power = state.range(0) == 2 ? 0 : 1;
  SimImage image = imager.See(view, grey);
  image *= view.readout.exposure.count();
  for (auto _ : state) {
    if (state.range(0) == 0) {
      benchmark::DoNotOptimize(imager.See(view, grey));
    } else {
      benchmark::DoNotOptimize(imager.Read(image, view.readout));
    }
  }
}
BENCHMARK(BM_FramePart)->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gonio
