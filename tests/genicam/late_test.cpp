// SPDX-License-Identifier: Apache-2.0
// Cameras that apply a change of the exposure time a frame or two late. Counts of the double are
// those of the exposure that a frame really had, so that a frame that says another one is caught.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/genicam/gige_rig.h"

namespace gonio {
namespace {

using testing::HasSubstr;
using testing::Not;

// Up and down, repeated, and by little; s.
constexpr double kExposures[] = {0.004, 0.02, 0.02, 0.001, 0.0011, 0.03, 0.0002, 0.0002, 0.004};

struct Lateness {
  const char* name;
  int frames;
  bool chunks;
  int discarded;  // after a change, where frames do not say
};
class LateSettings : public testing::TestWithParam<Lateness> {};

// Example failure is the frame of 4 ms that says 20 ms.
TEST_P(LateSettings, NoFrameIsTakenForOneOfAnotherExposure) {
  GigeCameraSettings late = DoubleSettings();
  late.late_frames = GetParam().frames;
  late.chunks = GetParam().chunks;
  GenicamSettings settings = DriverSettings();
  settings.discarded_on_change = GetParam().discarded;
  settings.discarded_first = GetParam().discarded;
  GigeRig rig(settings, late);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  for (const double exposure : kExposures) {
    const auto frame = rig.driver().Capture(Seconds(exposure), {});
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_DOUBLE_EQ(frame->exposure.count(), exposure);
    ExpectRightCounts(*frame);
  }
  const GenicamCounters counters = rig.driver().counters();
  EXPECT_EQ(counters.frames, std::ssize(kExposures));
  // On a machine with much to do a frame may come too late, too, and is taken again: then there are
  // more of them to count.
  if (counters.retries > 0) return;
  if (GetParam().chunks) {
    // Of the seven changes, the first is covered by the frame thrown away after opening.
    EXPECT_EQ(counters.late, 7 * GetParam().frames - std::min(1, GetParam().frames));
    EXPECT_EQ(counters.discarded, 1);
  } else {
    EXPECT_EQ(counters.late, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(All, LateSettings,
                         testing::Values(Lateness{"InTimeWithChunks", 0, true, 1},
                                         Lateness{"OneFrameWithChunks", 1, true, 1},
                                         Lateness{"TwoFramesWithChunks", 2, true, 1},
                                         Lateness{"OneFrameWithout", 1, false, 1},
                                         Lateness{"TwoFramesWithoutButToldSo", 2, false, 2}),
                         [](const auto& each) { return std::string(each.param.name); });

// What is not promised without chunk data, and that the tests above could fail.
TEST(LateSettings, WithoutChunksACameraThatIsLaterThanAllowedForIsNotSeen) {
  GigeCameraSettings late = DoubleSettings();
  late.late_frames = 2;
  GigeRig rig(DriverSettings(), late);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  ASSERT_TRUE(rig.driver().Capture(Seconds(0.004), {}).ok());
  ASSERT_TRUE(rig.driver().Capture(Seconds(0.004), {}).ok());
  ASSERT_TRUE(rig.driver().Capture(Seconds(0.004), {}).ok());
  const auto frame = rig.driver().Capture(Seconds(0.02), {});
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_DOUBLE_EQ(frame->exposure.count(), 0.02);
  EXPECT_EQ(frame->counts[0], 1e4 * 0.004);
}

// A frame that is late by its settings may take as long as those before: it does not come too late.
TEST(LateSettings, AFrameOfTheLongExposureBeforeIsWaitedFor) {
  GigeCameraSettings late = DoubleSettings();
  late.late_frames = 1;
  late.chunks = true;
  late.rate = 1;
  GigeRig rig(DriverSettings(), late);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  for (const double exposure : {0.8, 0.001}) {
    const auto frame = rig.driver().Capture(Seconds(exposure), {});
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_DOUBLE_EQ(frame->exposure.count(), exposure);
    ExpectRightCounts(*frame);
  }
  EXPECT_EQ(rig.driver().counters().retries, 0);
}

// A camera whose settings never come into force is not waited for without end.
TEST(LateSettings, ACameraThatStaysAtEarlierSettingsIsAnError) {
  GigeCameraSettings late = DoubleSettings();
  late.late_frames = 100;
  late.chunks = true;
  GenicamSettings settings = DriverSettings();
  settings.retries = 1;
  GigeRig rig(settings, late);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  const auto frame = rig.driver().Capture(Seconds(0.004), {});
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::kProtocol) << frame.error().message;
  EXPECT_THAT(frame.error().message,
              HasSubstr("frames are taken with 0.01 s and 0 dB, but the camera is set to 0.004 s"));
}

TEST(ChunkData, GivesEachFrameItsGain) {
  GigeCameraSettings chunks = DoubleSettings();
  chunks.chunks = true;
  GenicamSettings settings = DriverSettings();
  settings.gain_db = 6.5;
  GigeRig rig(settings, chunks);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  EXPECT_THAT(rig.driver().identity(), HasSubstr("frames say their exposure"));
  const auto frame = rig.driver().Capture(Seconds(0.004), {});
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_DOUBLE_EQ(frame->gain_db, 6.5);
  ExpectRightCounts(*frame);
}

// Example failure is chunk data that another program has left on.
TEST(ChunkData, IsLeftOffWhereItIsNotWanted) {
  GigeCameraSettings chunks = DoubleSettings();
  chunks.chunks = true;
  GenicamSettings settings = DriverSettings();
  settings.chunk_data = false;
  GigeRig rig(settings, chunks);
  ASSERT_TRUE(rig.camera.ok()) << rig.camera.error().message;
  EXPECT_THAT(rig.driver().identity(), Not(HasSubstr("frames say their exposure")));
  for (const double exposure : {0.001, 0.002}) {
    const auto frame = rig.driver().Capture(Seconds(exposure), {});
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    ExpectRightCounts(*frame);
  }
  EXPECT_EQ(rig.driver().counters().discarded, 2);
}

}  // namespace
}  // namespace gonio
