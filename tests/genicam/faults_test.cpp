// SPDX-License-Identifier: Apache-2.0
// What the camera and the network do wrong, over real GVCP and GVSP. Real time passes here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/genicam/gige_rig.h"

namespace gonio {
namespace {

using testing::HasSubstr;

// Looks again and again; the test's own time-out ends what never comes.
template <typename Condition>
void WaitFor(const Condition& condition) {
  while (!condition()) std::this_thread::yield();
}

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return Seconds(std::chrono::steady_clock::now() - start).count();
}

// Example failure is a frame with a hole of zeros where a packet was lost.
TEST(GenicamFaults, TakesFramesWithLostPacketsAgain) {
  GenicamSettings settings = DriverSettings();
  settings.retries = 20;
  GigeRig rig(settings);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  rig.device->SetPacketLoss(0.05);
  for (int i = 0; i < 20; ++i) {
    const auto frame = rig.driver().Capture(Seconds(0.001), {});
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    ExpectRightCounts(*frame);
  }
  // A frame is 7 packets: 3 of 10 frames are hit.
  const GenicamCounters counters = rig.driver().counters();
  EXPECT_EQ(counters.frames, 20);
  EXPECT_GT(counters.retries, 0);
  EXPECT_FALSE(counters.bad.empty());
}

// Example failure is a lost packet that costs a frame although the camera would send it again.
TEST(GenicamFaults, LostPacketsCostNoFrameWhereTheCameraSendsThemAgain) {
  GigeCameraSettings resends = DoubleSettings();
  resends.resends = true;
  GigeRig rig(DriverSettings(), resends);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  rig.device->SetPacketLoss(0.05);
  for (int i = 0; i < 20; ++i) {
    const auto frame = rig.driver().Capture(Seconds(0.001), {});
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    ExpectRightCounts(*frame);
  }
  EXPECT_LE(rig.driver().counters().retries, 2);  // 7 without
}

TEST(GenicamFaults, TimesOutWhenAllPacketsAreLost) {
  GenicamSettings settings = DriverSettings();
  settings.retries = 1;
  settings.margin = Seconds(0.3);
  GigeRig rig(settings);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  rig.device->SetPacketLoss(1);
  const auto frame = rig.driver().Capture(Seconds(0.001), {});
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::kTimeout) << frame.error().message;
  EXPECT_THAT(frame.error().message, HasSubstr("no frame came (2 tries)"));
  EXPECT_EQ(rig.driver().counters().bad.at("none"), 2);
  // As good as new once the cable is in again.
  rig.device->SetPacketLoss(0);
  const auto next = rig.driver().Capture(Seconds(0.001), {});
  ASSERT_TRUE(next.ok()) << next.error().message;
  ExpectRightCounts(*next);
}

// Example failure is a camera that goes on with the settings of power-up: Mono8, the whole sensor.
TEST(GenicamFaults, IsSetAgainAfterItWasAwayForAMoment) {
  GenicamSettings settings = DriverSettings();
  settings.gain_db = 12;
  settings.black_level = 20;
  GigeRig rig(settings);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  ASSERT_TRUE(rig.driver().Capture(Seconds(0.001), {}).ok());
  rig.device->Disappear();
  ASSERT_TRUE(rig.device->Return().ok());
  const auto frame = rig.driver().Capture(Seconds(0.001), {});
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_DOUBLE_EQ(frame->gain_db, 12);
  EXPECT_DOUBLE_EQ(frame->black_level, 20);
  ExpectRightCounts(*frame);
  EXPECT_EQ(rig.driver().counters().reopened, 1);
}

TEST(GenicamFaults, IsFoundAgainWhenItComesBackDuringTheSearch) {
  GigeRig rig;
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  ASSERT_TRUE(rig.driver().Capture(Seconds(0.001), {}).ok());
  rig.device->Disappear();
  std::jthread plug([&] {
    WaitFor([&] { return rig.driver().counters().retries > 0; });  // it has given it up
    EXPECT_TRUE(rig.device->Return().ok());
  });
  const auto frame = rig.driver().Capture(Seconds(0.002), {});
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  ExpectRightCounts(*frame);
  EXPECT_EQ(rig.driver().counters().reopened, 1);
}

TEST(GenicamFaults, IsDisconnectedWhenItStaysAway) {
  GenicamSettings settings = DriverSettings();
  settings.reopen_limit = Seconds(1);
  GigeRig rig(settings);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  rig.device->Disappear();
  const auto start = std::chrono::steady_clock::now();
  const auto frame = rig.driver().Capture(Seconds(0.001), {});
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::kDisconnected) << frame.error().message;
  EXPECT_LT(SecondsSince(start), rig.driver().CaptureLimit(Seconds(0.001)).count());
  // And it comes back as soon as it can.
  ASSERT_TRUE(rig.device->Return().ok());
  const auto next = rig.driver().Capture(Seconds(0.001), {});
  ASSERT_TRUE(next.ok()) << next.error().message;
}

// Example failure is a cancelled exposure whose image is handed out as the next one's.
TEST(GenicamFaults, IsCancelledDuringALongExposure) {
  GigeCameraSettings slow = DoubleSettings();
  slow.rate = 2;
  GigeRig rig(DriverSettings(), slow);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  ASSERT_TRUE(rig.driver().Capture(Seconds(0.001), {}).ok());
  std::stop_source stop;
  std::jthread user([&] {
    WaitFor([&] { return rig.device->exposing(); });
    stop.request_stop();
  });
  const int before = rig.device->exposures();
  const auto frame = rig.driver().Capture(Seconds(2), stop.get_token());
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::kCancelled);
  EXPECT_EQ(rig.device->exposures(), before);  // it takes 1 s, and is under way
  const auto next = rig.driver().Capture(Seconds(0.003), {});
  ASSERT_TRUE(next.ok()) << next.error().message;
  EXPECT_DOUBLE_EQ(next->exposure.count(), 0.003);
  ExpectRightCounts(*next);
}

// A second program may look, but not touch.
TEST(GenicamFaults, RefusesACameraThatAnotherProgramControls) {
  GigeRig rig;
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  const auto second = GenicamCamera::Open(DriverSettings(), *rig.clock);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kRefused);
  EXPECT_THAT(second.error().message, HasSubstr("another program controls"));
  EXPECT_TRUE(rig.driver().Capture(Seconds(0.001), {}).ok());
}

// Nobody's edge comes: the camera waits, not the caller.
TEST(GenicamFaults, TimesOutWhenNoTriggerComes) {
  GenicamSettings settings = DriverSettings();
  settings.trigger_line = "Line0";
  settings.retries = 0;
  GigeRig rig(settings);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  const auto frame = rig.driver().Capture(Seconds(0.001), {});
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::kTimeout) << frame.error().message;
}

}  // namespace
}  // namespace gonio
