// SPDX-License-Identifier: Apache-2.0
// What frames and calibrations must share to be used together, and how their numbers are laid out.

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera.h"

namespace gonio {

// A *site* is one count of a frame: Frame::counts[i]. A pixel of an RGB camera has three, of a
// mono or Bayer camera one. All images of this library hold one number per site, in the order of
// Frame::counts, so that nothing is interpolated and no colour borrows from another.
using SiteImage = std::vector<float>;
using SiteMask = std::vector<std::uint8_t>;  // what a number means is said where it is used

// The part of a camera's settings on which its calibration depends.
struct SensorFormat {
  std::string camera;  // Camera::identity()
  int left = 0;        // of the region that is read out, on the sensor, pixels
  int top = 0;
  int width = 0;
  int height = 0;
  PixelLayout layout = PixelLayout::kMono;
  int full_scale = 4095;  // counts
  double gain_db = 0;

  std::size_t sites() const {
    return static_cast<std::size_t>(width) * height * CountsPerPixel(layout);
  }
  bool operator==(const SensorFormat&) const = default;
};

// Why frames of `other` cannot be corrected with what was calibrated as `calibrated`: "width is
// 640, calibrated for 1280". Empty if they can. Gains may differ by 1 millidecibel.
std::string DifferenceOf(const SensorFormat& calibrated, const SensorFormat& other);
// The same for one frame, which does not know its camera, place on the sensor or full scale.
std::string DifferenceOf(const SensorFormat& calibrated, const Frame& frame);

// Channels whose sites are told apart: 1 for a mono camera, whose only channel counts for all
// three colours, otherwise 3 (red, green, blue).
int ChannelsOf(PixelLayout layout);
// Channel of each site of one row: rows alternate in a Bayer mosaic, so `row` matters only for
// those.
std::vector<std::uint8_t> RowChannels(const SensorFormat& format, int row);
// Sites per row.
int RowSites(const SensorFormat& format);

// Hands every site to visit(site, channel), row by row.
template <typename Visit>
void VisitSites(const SensorFormat& format, const Visit& visit) {
  const std::vector<std::uint8_t> rows[2] = {RowChannels(format, 0), RowChannels(format, 1)};
  std::size_t site = 0;
  for (int y = 0; y < format.height; ++y) {
    for (const std::uint8_t channel : rows[y & 1]) visit(site++, int{channel});
  }
}

// What `values` are in the sites of one channel for which `mask` (empty: everywhere) is 0.
std::vector<float> ChannelValues(const SensorFormat& format, const SiteImage& values, int channel,
                                 const SiteMask& mask);

}  // namespace gonio
