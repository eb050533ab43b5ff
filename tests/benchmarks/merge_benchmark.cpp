// SPDX-License-Identifier: Apache-2.0
// How fast exposures are merged, against copying them and against OpenCV's merge.
//
// build/release/bin/gonio_merge_benchmarks; items are pixels of one channel (sites) of one frame.

#include <benchmark/benchmark.h>

#include <cstring>
#include <opencv2/core.hpp>
#ifdef GONIO_HAVE_OPENCV_PHOTO
#include <opencv2/photo.hpp>
#endif

#include "acquisition/radiometry/frame_correction.h"
#include "acquisition/radiometry/hdr_merge.h"
#include "sim/random.h"

namespace gonio {
namespace {

constexpr int kWidth = 1280;
constexpr int kHeight = 960;
const std::vector<double> kExposures = {0.01, 0.04, 0.16, 0.64};

SensorModel Model(PixelLayout layout) {
  SensorModel model;
  model.format = {.camera = "c", .width = kWidth, .height = kHeight, .layout = layout};
  model.gain = 2;
  model.read_noise = 5;
  return model;
}

// A gradient from dark to four times the full scale of the longest exposure.
std::vector<Frame> RawFrames(const SensorFormat& format) {
  Random random(1, 1);
  std::vector<Frame> frames;
  for (const double t : kExposures) {
    Frame frame{.width = format.width,
                .height = format.height,
                .layout = format.layout,
                .counts = std::vector<std::uint16_t>(format.sites()),
                .exposure = Seconds(t),
                .black_level = 64};
    for (std::size_t i = 0; i < frame.counts.size(); ++i) {
      const double mean = 64 + 25000 * t * static_cast<double>(i) / frame.counts.size();
      frame.counts[i] = static_cast<std::uint16_t>(std::min(4095.0, mean + 5 * random.Uniform()));
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

std::vector<CorrectedFrame> Corrected(PixelLayout layout) {
  const SensorModel model = Model(layout);
  std::vector<CorrectedFrame> frames;
  for (const Frame& frame : RawFrames(model.format)) {
    frames.push_back(*Correct(model, frame, 1, nullptr));
  }
  return frames;
}

void CountSites(benchmark::State& state, PixelLayout layout) {
  const auto sites = static_cast<std::int64_t>(Model(layout).format.sites());
  state.SetItemsProcessed(state.iterations() * sites * std::ssize(kExposures));
}

void CorrectFrames(benchmark::State& state, PixelLayout layout) {
  const SensorModel model = Model(layout);
  const std::vector<Frame> frames = RawFrames(model.format);
  for (auto _ : state) {
    for (const Frame& frame : frames) benchmark::DoNotOptimize(Correct(model, frame, 1, nullptr));
  }
  CountSites(state, layout);
}
BENCHMARK_CAPTURE(CorrectFrames, mono, PixelLayout::kMono)->Unit(benchmark::kMillisecond);

void MergeFrames(benchmark::State& state, PixelLayout layout) {
  const std::vector<CorrectedFrame> frames = Corrected(layout);
  for (auto _ : state) {
    benchmark::DoNotOptimize(Merge(frames, {.shared_noise = 0.01, .averaged_sites = 1e4}));
  }
  CountSites(state, layout);
}
BENCHMARK_CAPTURE(MergeFrames, mono, PixelLayout::kMono)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(MergeFrames, bayer, PixelLayout::kBayerRg)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(MergeFrames, rgb, PixelLayout::kRgb)->Unit(benchmark::kMillisecond);

// The same bytes, only moved: five per site and frame.
void CopyFrames(benchmark::State& state, PixelLayout layout) {
  const std::vector<CorrectedFrame> frames = Corrected(layout);
  std::vector<CorrectedFrame> copies = frames;
  for (auto _ : state) {
    for (std::size_t k = 0; k < frames.size(); ++k) {
      std::memcpy(copies[k].electrons.data(), frames[k].electrons.data(),
                  frames[k].electrons.size() * sizeof(float));
      std::memcpy(copies[k].unusable.data(), frames[k].unusable.data(), frames[k].unusable.size());
      benchmark::ClobberMemory();
    }
  }
  CountSites(state, layout);
}
BENCHMARK_CAPTURE(CopyFrames, mono, PixelLayout::kMono)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(CopyFrames, rgb, PixelLayout::kRgb)->Unit(benchmark::kMillisecond);

#ifdef GONIO_HAVE_OPENCV_PHOTO
// OpenCV's merge takes 8 bits only, and three channels as well as one. One thread, as ours.
void DebevecMerge(benchmark::State& state, int channels) {
  cv::setNumThreads(1);
  const PixelLayout layout = channels == 3 ? PixelLayout::kRgb : PixelLayout::kMono;
  std::vector<cv::Mat> images;
  for (const Frame& frame : RawFrames(Model(layout).format)) {
    cv::Mat image(kHeight, kWidth, CV_8UC(channels));
    for (std::size_t i = 0; i < frame.counts.size(); ++i) {
      image.data[i] = static_cast<unsigned char>(frame.counts[i] >> 4);
    }
    images.push_back(image);
  }
  const std::vector<float> times(kExposures.begin(), kExposures.end());
  // A straight one. OpenCV 4.6 would make it itself, but for one channel writes past its end.
  cv::Mat response(256, 1, CV_32FC(channels));
  for (int i = 0; i < 256; ++i) response.row(i).setTo(cv::Scalar::all(std::max(i, 1)));
  const auto merge = cv::createMergeDebevec();
  cv::Mat result;
  for (auto _ : state) merge->process(images, result, times, response);
  CountSites(state, layout);
}
BENCHMARK_CAPTURE(DebevecMerge, mono, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(DebevecMerge, rgb, 3)->Unit(benchmark::kMillisecond);
#endif

}  // namespace
}  // namespace gonio
