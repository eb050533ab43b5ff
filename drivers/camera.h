// SPDX-License-Identifier: Apache-2.0
// The detector: a camera, or a photodiode as a camera of one pixel.

#pragma once

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/error.h"

namespace gonio {

struct CameraInfo {
  int width = 1;            // pixels of the region that is read out
  int height = 1;           // pixels
  int channels = 3;         // red, green, blue, interleaved
  int full_scale = 4095;    // counts; this value and above mean saturated
  Seconds min_exposure{0};  // > 0
  Seconds max_exposure{0};  // > min_exposure
  Seconds readout{0};       // from the end of the exposure to the next possible start
};

// One exposure as it left the detector, with the settings it was *really* taken with.
struct Frame {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<std::uint16_t> counts;  // row-major, channels interleaved, width*height*channels
  Seconds exposure{0};
  double black_level = 0;  // counts at zero light and zero exposure
  Seconds start{0};        // on the session's clock
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
