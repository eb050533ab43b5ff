// SPDX-License-Identifier: Apache-2.0
// A GigE Vision camera that is not there: what it answers comes over real UDP.

#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/error.h"
#include "drivers/camera.h"

namespace gonio {

struct GigeCameraSettings {
  // Of a network interface, so 127.0.0.1. One camera per address and network namespace: the port,
  // UDP 3956, is fixed.
  std::string address = "127.0.0.1";
  std::string vendor = "Goniopilot";
  std::string model = "GigE double";
  std::string serial = "GP0001";  // < 16 characters
  std::string firmware = "1.0";
  int sensor_width = 1024;   // pixels, a multiple of 4
  int sensor_height = 1024;  // pixels, a multiple of 2
  int min_exposure_us = 20;
  int max_exposure_us = 2'000'000;
  double max_gain_db = 24;    // in steps of 0.1
  int max_black_level = 255;  // counts
  double temperature_c = 35;
  double rate = 1;         // so many seconds of exposure take one of the machine's
  std::uint32_t seed = 1;  // of what is lost
  // Frames after a change of the exposure time that are still taken with the one before.
  int late_frames = 0;
  // Whether frames can say how they were taken (SFNC's chunk data: ExposureTime, Gain).
  bool chunks = false;
  // Whether packets are sent again when the client asks for them.
  bool resends = false;
};

// What a frame is taken with, read from the camera's registers as the exposure begins.
struct GigeExposure {
  Seconds exposure{0};
  double gain_db = 0;
  double black_level = 0;  // counts
  int x = 0;               // of the region's first pixel, on the sensor
  int y = 0;
  int width = 0;
  int height = 0;
  PixelLayout layout = PixelLayout::kMono;
  int full_scale = 255;  // counts
  std::string pixel_format;

  std::size_t counts() const {
    return static_cast<std::size_t>(width) * height * CountsPerPixel(layout);
  }
};

// Fills counts(), right-aligned, all 0 when it is called. Runs on the camera's thread at the end of
// the exposure. Counts above the full scale are clipped.
using GigeExpose =
    std::function<void(const GigeExposure& settings, std::vector<std::uint16_t>& counts)>;

// Serves GVCP and GVSP with a GenICam description of its own: ExposureTime [us], Gain [dB],
// BlackLevel [counts], DeviceTemperature [deg C], Width in steps of 4 and Height of 2, OffsetX and
// OffsetY, software trigger, and the pixel formats Mono8, 10, 12, 16, 10p, 12p, 12Packed, BayerRG8,
// 12, 12p and RGB8. Gains are rounded to 0.1 dB and exposures to 1 us, as read back.
//
//   arv-tool-0.8 -a 127.0.0.1 control ExposureTime=5000 Gain
//
// A trigger during an exposure is not served. The end of acquisition ends an exposure that is under
// way; no image comes of it. Without a trigger mode it takes one frame after the other. It answers
// searches (broadcasts) that reach this machine.
//
// Its methods are for one thread; the camera has two of its own.
class GigeCamera {
 public:
  // kRefused: the address is no interface's, or its port is taken.
  static Result<std::unique_ptr<GigeCamera>> Serve(const GigeCameraSettings& settings,
                                                   GigeExpose expose);
  ~GigeCamera();
  GigeCamera(const GigeCamera&) = delete;
  GigeCamera& operator=(const GigeCamera&) = delete;

  // Share of the packets of images that never arrive.
  void SetPacketLoss(double ratio);
  void SetTemperature(double temperature_c);  // as of the next exposure

  // As if its power was cut; Return() brings it back with the settings of power-up. kRefused as
  // for Serve().
  void Disappear();
  Result<void> Return();

  int exposures() const;  // that have ended so far
  bool exposing() const;  // one is under way. Any thread

 private:
  class Impl;
  explicit GigeCamera(std::unique_ptr<Impl> impl);
  const std::unique_ptr<Impl> impl_;
};

}  // namespace gonio
