// SPDX-License-Identifier: Apache-2.0
// The promises of drivers/camera.h, asked of any camera. Include in one .cpp per test program and
// instantiate as in tests/conformance/axis.h.

#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>

#include "drivers/camera.h"

namespace gonio {

struct CameraSubject {
  std::shared_ptr<Clock> clock;
  std::unique_ptr<Camera> camera;
};
using CameraFactory = std::function<CameraSubject()>;

class CameraConformance : public testing::TestWithParam<CameraFactory> {
 protected:
  void SetUp() override { subject_ = GetParam()(); }
  Camera& camera() { return *subject_.camera; }
  Seconds now() const { return subject_.clock->Now(); }

  CameraSubject subject_;
};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(CameraConformance);

// Example failure is a driver that never filled in what the exposure logic divides by.
TEST_P(CameraConformance, DescribesItself) {
  const CameraInfo& info = camera().info();
  EXPECT_GT(info.width, 0);
  EXPECT_GT(info.height, 0);
  EXPECT_GT(info.full_scale, 0);
  EXPECT_GT(info.min_exposure, Seconds::zero());
  EXPECT_GT(info.max_exposure, info.min_exposure);
  EXPECT_FALSE(camera().name().empty());
}

// Promise 1. Example failure is a frame that carries the exposure asked for while the sensor
// rounded it to its row time.
TEST_P(CameraConformance, ReportsAnExposureNearTheOneAskedFor) {
  const CameraInfo& info = camera().info();
  const double ratio = info.max_exposure / info.min_exposure;
  for (const double step : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const Seconds asked = std::min(info.max_exposure, info.min_exposure * std::pow(ratio, step));
    const auto frame = camera().Capture(asked, {});
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_GT(frame->exposure, Seconds::zero());
    EXPECT_NEAR(frame->exposure / asked, 1, 0.1);
  }
}

// Promise 1. Example failure is a driver that clamps in silence.
TEST_P(CameraConformance, RefusesExposuresOutsideItsRangeAtOnce) {
  const CameraInfo& info = camera().info();
  const Seconds before = now();
  for (const Seconds exposure :
       {Seconds(0), info.min_exposure * 0.5, info.max_exposure * 1.5, Seconds(std::nan(""))}) {
    const auto frame = camera().Capture(exposure, {});
    ASSERT_FALSE(frame.ok()) << exposure.count();
    EXPECT_EQ(frame.error().code, ErrorCode::kRefused);
    EXPECT_NE(frame.error().message.find(camera().name()), std::string::npos);
  }
  EXPECT_LT((now() - before).count(), 0.1);
}

// Promise 2. Example failure is a truncated buffer after a lost packet.
TEST_P(CameraConformance, ReturnsWholeFrames) {
  const CameraInfo& info = camera().info();
  for (int i = 0; i < 3; ++i) {
    const auto frame = camera().Capture(info.min_exposure, {});
    ASSERT_TRUE(frame.ok());
    EXPECT_EQ(frame->width, info.width);
    EXPECT_EQ(frame->height, info.height);
    EXPECT_EQ(frame->layout, info.layout);
    EXPECT_EQ(frame->counts.size(), info.counts());
    for (const std::uint16_t count : frame->counts) EXPECT_LE(count, info.full_scale);
  }
}

// Promise 3. Example failure is a camera that hands out what its queue still held.
TEST_P(CameraConformance, ReturnsFramesThatAreNotOlderThanTheCall) {
  const Seconds exposure = std::min(camera().info().max_exposure, Seconds(0.05));
  for (int i = 0; i < 3; ++i) {
    subject_.clock->SleepFor(Seconds(0.5));
    const Seconds called = now();
    const auto frame = camera().Capture(exposure, {});
    ASSERT_TRUE(frame.ok());
    EXPECT_GE(frame->start, called);
    EXPECT_LE((frame->start + frame->exposure).count(), now().count() + 1e-9);
  }
}

// Errors: kCancelled. Example failure is a ten-second exposure that Ctrl-C cannot end.
TEST_P(CameraConformance, IsCancelled) {
  std::stop_source stop;
  stop.request_stop();
  const auto frame = camera().Capture(camera().info().max_exposure, stop.get_token());
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::kCancelled);
  EXPECT_TRUE(camera().Capture(camera().info().min_exposure, {}).ok());
}

}  // namespace gonio
