// SPDX-License-Identifier: Apache-2.0
// The detector: a camera, or a photodiode as a camera of one pixel.

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"
#include "core/config.h"
#include "core/error.h"

namespace gonio {

// Which colour a pixel sees.
//
// Bayer mosaics are named as in GenICam's PFNC: by the first two pixels of the first row that is
// read out.
enum class PixelLayout {
  kMono,     // one count per pixel, all of the light
  kRgb,      // three counts per pixel, interleaved
  kBayerRg,  // one count per pixel, in cells of two by two: RG/GB
  kBayerGr,  // GR/BG
  kBayerGb,  // GB/RG
  kBayerBg,  // BG/GR
};
inline constexpr PixelLayout kPixelLayouts[] = {PixelLayout::kMono,    PixelLayout::kRgb,
                                                PixelLayout::kBayerRg, PixelLayout::kBayerGr,
                                                PixelLayout::kBayerGb, PixelLayout::kBayerBg};
// "mono", "rgb", "bayer-rg", ...: as in rig files and in the log.
const char* ToString(PixelLayout layout);
// The layout that `key` names. Throws ConfigError listing the names.
PixelLayout ReadPixelLayout(const ConfigNode& node, std::string_view key);
// Counts per pixel: 3 for kRgb, otherwise 1.
int CountsPerPixel(PixelLayout layout);
// 0, 1, 2: the colour that the pixel at column x, row y of a Bayer mosaic sees.
int BayerChannel(PixelLayout layout, int x, int y);

struct CameraInfo {
  int width = 1;   // pixels of the region that is read out
  int height = 1;  // pixels
  PixelLayout layout = PixelLayout::kRgb;
  int full_scale = 4095;    // counts; this value and above mean saturated
  Seconds min_exposure{0};  // > 0
  Seconds max_exposure{0};  // > min_exposure
  Seconds readout{0};       // from the end of the exposure to the next possible start

  std::size_t counts() const {
    return static_cast<std::size_t>(width) * height * CountsPerPixel(layout);
  }
};

// One exposure as it left the detector, with the settings it was *really* taken with.
struct Frame {
  int width = 0;
  int height = 0;
  PixelLayout layout = PixelLayout::kRgb;
  // Row-major, right-aligned (full scale of 12 bits is 4095), CountsPerPixel(layout) of each pixel.
  std::vector<std::uint16_t> counts;
  Seconds exposure{0};
  double gain_db = 0;
  double black_level = 0;                              // counts at zero light and zero exposure
  std::optional<double> temperature_c = std::nullopt;  // of the sensor, if the camera tells
  Seconds start{0};                                    // on the session's clock
};

// A detector that takes one frame at a time.
//
// Promises, checked by tests/conformance/camera.h:
//
//   1. Frame::exposure is the exposure used, which may differ from the one asked for by the
//      detector's own step; asking outside the range of info() is kRefused, nothing is exposed.
//   2. Capture() returns only whole frames of info()'s size. The axes may move again once it
//      returns.
//   3. No frame is older than the call that returns it.
//
// One thread. Errors: kTimeout, kDisconnected, kProtocol, kRefused, kCancelled as in axis.h.
class Camera {
 public:
  virtual ~Camera() = default;
  virtual const std::string& name() const = 0;
  // What the device said it is when it was opened, and the settings it was given, on one line.
  virtual const std::string& identity() const = 0;
  virtual const CameraInfo& info() const = 0;
  // Exposes and reads out: blocks for exposure + readout.
  virtual Result<Frame> Capture(Seconds exposure, std::stop_token stop) = 0;
};

}  // namespace gonio
