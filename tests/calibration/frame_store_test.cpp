// SPDX-License-Identifier: Apache-2.0
#include "acquisition/calibration/frame_store.h"

#include <gmock/gmock.h>

#include "core/file.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

SensorFormat SmallFormat() {
  SensorFormat format;
  format.camera = "small";
  format.width = 2;
  format.height = 1;
  format.layout = PixelLayout::kRgb;
  return format;
}

StoredFrame SomeFrame() {
  StoredFrame stored;
  stored.frame = {.width = 2,
                  .height = 1,
                  .counts = {1, 2, 3, 4000, 5, 65535},
                  .exposure = Seconds(0.1 + 1e-16),
                  .black_level = 64,
                  .temperature_c = 31.25,
                  .start = Seconds(7.5)};
  stored.monitor = 0.99871234567;
  return stored;
}

TEST(FrameStore, GivesFramesBackToTheLastBit) {
  const TempDir dir;
  FrameStore store(dir.path() / "frames", SmallFormat(), {{"step", "flat"}}, false);
  store.FixExposures({0.1, 0.2});
  store.Write(1, SomeFrame());
  const FrameStore again(dir.path() / "frames", SmallFormat(), {{"step", "flat"}}, false);
  EXPECT_EQ(again.exposures(), (std::vector<double>{0.1, 0.2}));
  EXPECT_FALSE(again.Read(0));
  const auto read = again.Read(1);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->frame.counts, SomeFrame().frame.counts);
  EXPECT_EQ(read->frame.exposure, SomeFrame().frame.exposure);
  EXPECT_EQ(read->frame.temperature_c, SomeFrame().frame.temperature_c);
  EXPECT_EQ(read->frame.start, SomeFrame().frame.start);
  EXPECT_EQ(read->monitor, SomeFrame().monitor);
}

// Example failure: counts of a disk error, which look like a picture.
TEST(FrameStore, DoesNotBelieveChangedCounts) {
  const TempDir dir;
  FrameStore store(dir.path() / "frames", SmallFormat(), {}, false);
  store.FixExposures({0.1});
  store.Write(0, SomeFrame());
  const auto tiff = dir.path() / "frames/frame-0001.tiff";
  std::string bytes = ReadTextFile(tiff);
  bytes[bytes.size() / 2] ^= 1;
  WriteFileAtomically(tiff, [&](std::ostream& out) { out << bytes; });
  EXPECT_FALSE(store.Read(0));
}

}  // namespace
}  // namespace gonio
