// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/frame_correction.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/check.h"

namespace gonio {
namespace {

// Electrons of each possible count, and from which count on nothing is known.
struct CountTable {
  std::vector<float> electrons;
  int saturated = 0;
};

CountTable TableOf(const SensorModel& sensor, double black) {
  CountTable table;
  table.saturated = sensor.format.full_scale;
  for (int n = 0; n <= sensor.format.full_scale; ++n) {
    const auto counts = sensor.linearity.Correct(n - black);
    if (!counts) table.saturated = std::min(table.saturated, n);
    table.electrons.push_back(static_cast<float>(sensor.gain * counts.value_or(n - black)));
  }
  return table;
}

void MarkNeighbours(const SensorFormat& format, SiteMask* mask) {
  if (std::none_of(mask->begin(), mask->end(), [](auto m) { return m != 0; })) return;
  cv::Mat image(format.height, format.width, CV_8UC(CountsPerPixel(format.layout)), mask->data());
  cv::Mat grown;
  cv::dilate(image, grown, cv::Mat());  // 3 x 3
  grown.copyTo(image);
}

void SubtractDark(const SensorModel& sensor, const Dark& dark, CorrectedFrame* corrected) {
  const bool straight = sensor.linearity.is_identity();
  const auto gain = static_cast<float>(sensor.gain);
  corrected->extra.resize(dark.counts.size());
  for (std::size_t i = 0; i < dark.counts.size(); ++i) {
    float counts = dark.counts[i];
    if (!straight) {
      counts = static_cast<float>(sensor.linearity.Correct(counts).value_or(counts));
    }
    corrected->electrons[i] -= gain * counts;
    corrected->extra[i] = gain * (dark.current[i] + gain * dark.variance[i]);
  }
}

}  // namespace

Result<CorrectedFrame> Correct(const SensorModel& sensor, const Frame& frame, double monitor,
                               const Dark* dark) {
  const std::string difference = DifferenceOf(sensor.format, frame);
  if (!difference.empty()) return Error{ErrorCode::kRefused, "frame: " + difference};
  const std::size_t sites = sensor.format.sites();
  GONIO_CHECK(sensor.bad.empty() || sensor.bad.size() == sites, "a mask of all sites");
  GONIO_CHECK(dark == nullptr || dark->counts.size() == sites, "a dark of all sites");
  const CountTable table = TableOf(sensor, frame.black_level);
  CorrectedFrame corrected;
  corrected.format = sensor.format;
  corrected.exposure = frame.exposure.count() + sensor.exposure_offset;
  if (!(corrected.exposure > 0)) {
    return Error{ErrorCode::kRefused, "frame: not longer than what the shutter takes off"};
  }
  corrected.monitor = monitor;
  corrected.full = table.electrons[static_cast<std::size_t>(table.saturated)];
  corrected.electrons.resize(sites);
  corrected.unusable.resize(sites);
  const int last = sensor.format.full_scale;
  for (std::size_t i = 0; i < sites; ++i) {
    const int n = std::min<int>(frame.counts[i], last);
    corrected.electrons[i] = table.electrons[static_cast<std::size_t>(n)];
    // A hot site that is full by itself says nothing about its neighbours' light.
    const bool bad = !sensor.bad.empty() && sensor.bad[i] != 0;
    corrected.unusable[i] = n >= table.saturated && !bad ? kSaturatedSite : 0;
  }
  MarkNeighbours(sensor.format, &corrected.unusable);
  if (!sensor.bad.empty()) {
    for (std::size_t i = 0; i < sites; ++i) {
      if (sensor.bad[i] != 0) corrected.unusable[i] |= kBadSite;
    }
  }
  const double read = sensor.read_noise * sensor.read_noise;
  corrected.floor = read + sensor.gain * sensor.gain / 12;
  if (dark != nullptr) SubtractDark(sensor, *dark, &corrected);
  return corrected;
}

}  // namespace gonio
