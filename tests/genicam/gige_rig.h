// SPDX-License-Identifier: Apache-2.0
// A GigE Vision double and the driver that talks to it over loopback.

#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>

#include "core/clock.h"
#include "drivers/genicam_camera.h"
#include "sim/gige_camera.h"

namespace gonio {

// What the double shows: different at each pixel, and proportional to exposure and gain.
inline int GigeCount(const GigeExposure& settings, std::size_t index) {
  const double light = 1e4 * settings.exposure.count() * std::pow(10, settings.gain_db / 20);
  return static_cast<int>(std::lround(light) + settings.black_level + index % 101 + 3 * settings.x +
                          7 * settings.y) %
         (settings.full_scale + 1);
}
inline void ShowCounts(const GigeExposure& settings, std::vector<std::uint16_t>& counts) {
  for (std::size_t i = 0; i < counts.size(); ++i) {
    counts[i] = static_cast<std::uint16_t>(GigeCount(settings, i));
  }
}

// Whether the frame's counts are those of the exposure that it says, from a driver with
// DriverSettings(). Counts of 64 x 48 Mono12 pixels.
inline void ExpectRightCounts(const Frame& frame) {
  const GigeExposure expected{.exposure = frame.exposure,
                              .gain_db = frame.gain_db,
                              .black_level = frame.black_level,
                              .width = frame.width,
                              .height = frame.height,
                              .full_scale = 4095,
                              .pixel_format = "Mono12"};
  ASSERT_EQ(frame.counts.size(), expected.counts());
  for (std::size_t i = 0; i < frame.counts.size(); ++i) {
    ASSERT_EQ(frame.counts[i], GigeCount(expected, i)) << i;
  }
}

inline GigeCameraSettings DoubleSettings() {
  GigeCameraSettings settings;
  settings.rate = 20;  // exposures pass quickly
  return settings;
}

inline GenicamSettings DriverSettings() {
  GenicamSettings settings;
  settings.name = "camera";
  settings.address = "127.0.0.1";
  settings.width = 64;
  settings.height = 48;
  settings.packet_size = 1400;
  settings.margin = Seconds(0.4);
  settings.readout = Seconds(0.01);
  return settings;
}

inline std::unique_ptr<GigeCamera> ServeDouble(
    const GigeCameraSettings& settings = DoubleSettings()) {
  auto camera = GigeCamera::Serve(settings, ShowCounts);
  EXPECT_TRUE(camera.ok()) << camera.error().message;
  return camera ? std::move(camera).value() : nullptr;
}

struct GigeRig {
  explicit GigeRig(const GenicamSettings& settings = DriverSettings(),
                   const GigeCameraSettings& double_settings = DoubleSettings())
      : clock(std::make_unique<SystemClock>(double_settings.rate)),
        device(ServeDouble(double_settings)),
        camera(GenicamCamera::Open(settings, *clock)) {}

  GenicamCamera& driver() { return *camera.value(); }

  std::unique_ptr<SystemClock> clock;
  std::unique_ptr<GigeCamera> device;
  Result<std::unique_ptr<GenicamCamera>> camera;
};

}  // namespace gonio
