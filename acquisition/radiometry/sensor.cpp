// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/sensor.h"

#include <fmt/format.h>

#include <cmath>

#include "brdf/brdf.h"
#include "core/check.h"

namespace gonio {
namespace {

constexpr double kSameGainDb = 1e-3;

template <typename T>
std::string Differs(const char* what, const T& calibrated, const T& other) {
  return fmt::format("{} is {}, calibrated for {}", what, other, calibrated);
}

}  // namespace

std::string DifferenceOf(const SensorFormat& calibrated, const SensorFormat& other) {
  if (calibrated.camera != other.camera) return Differs("camera", calibrated.camera, other.camera);
  if (calibrated.left != other.left) return Differs("left", calibrated.left, other.left);
  if (calibrated.top != other.top) return Differs("top", calibrated.top, other.top);
  if (calibrated.width != other.width) return Differs("width", calibrated.width, other.width);
  if (calibrated.height != other.height) return Differs("height", calibrated.height, other.height);
  if (calibrated.layout != other.layout) {
    return Differs("pixel layout", ToString(calibrated.layout), ToString(other.layout));
  }
  if (calibrated.full_scale != other.full_scale) {
    return Differs("full scale", calibrated.full_scale, other.full_scale);
  }
  if (!(std::abs(calibrated.gain_db - other.gain_db) <= kSameGainDb)) {
    return Differs("gain in dB", calibrated.gain_db, other.gain_db);
  }
  return "";
}

std::string DifferenceOf(const SensorFormat& calibrated, const Frame& frame) {
  SensorFormat format = calibrated;
  format.width = frame.width;
  format.height = frame.height;
  format.layout = frame.layout;
  format.gain_db = frame.gain_db;
  std::string difference = DifferenceOf(calibrated, format);
  if (difference.empty() && frame.counts.size() != calibrated.sites()) {
    difference = Differs("number of counts", calibrated.sites(), frame.counts.size());
  }
  return difference;
}

int ChannelsOf(PixelLayout layout) { return layout == PixelLayout::kMono ? 1 : kChannels; }

int RowSites(const SensorFormat& format) { return format.width * CountsPerPixel(format.layout); }

std::vector<std::uint8_t> RowChannels(const SensorFormat& format, int row) {
  std::vector<std::uint8_t> channels(static_cast<std::size_t>(RowSites(format)));
  for (int x = 0; x < RowSites(format); ++x) {
    int channel = 0;
    if (format.layout == PixelLayout::kRgb) {
      channel = x % kChannels;
    } else if (format.layout != PixelLayout::kMono) {
      channel = BayerChannel(format.layout, x, row);
    }
    channels[static_cast<std::size_t>(x)] = static_cast<std::uint8_t>(channel);
  }
  return channels;
}

std::vector<float> ChannelValues(const SensorFormat& format, const SiteImage& values, int channel,
                                 const SiteMask& mask) {
  GONIO_CHECK(values.size() == format.sites(), "one value for each site");
  std::vector<float> picked;
  VisitSites(format, [&](std::size_t i, int c) {
    if (c == channel && (mask.empty() || mask[i] == 0)) picked.push_back(values[i]);
  });
  return picked;
}

}  // namespace gonio
