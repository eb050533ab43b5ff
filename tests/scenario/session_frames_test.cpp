// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session_frames.h"

#include <gmock/gmock.h>

#include "acquisition/event_log_sqlite.h"
#include "tests/acquisition/simulated_rig.h"
#include "tests/core/temp_dir.h"
#include "tests/scenario/bench.h"

namespace gonio {
namespace {

// Keeps what the measurer returned beside the log.
TEST(SessionFrames, AreThoseThatWereTaken) {
  const TempDir dir;
  RigConfig rig = DefaultRig();
  rig.camera.layout = PixelLayout::kBayerGb;
  const FlatBrdf sample(Rgb(0.05, 0.2, 0.4));
  SimulatedRig simulated(sample, 1, rig);
  PoseMeasurer measurer = simulated.Prepared();
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  const auto record = measurer.Measure(PairAt(20, 30), std::nullopt, {}, 3);
  ASSERT_TRUE(record.ok()) << record.error().message;
  ASSERT_TRUE(
      log.AppendPose({.pose = 1, .proposal = {}, .predicted_error = {}, .after = {}}, *record)
          .ok());

  SessionFrames frames(dir / "s");
  const std::vector<Exposure> read = frames.Of(1);
  ASSERT_EQ(read.size(), record->exposures.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    const Exposure& was = record->exposures[i];
    EXPECT_EQ(read[i].frame.counts, was.frame.counts);
    EXPECT_EQ(read[i].frame.layout, was.frame.layout);
    EXPECT_EQ(read[i].frame.width, was.frame.width);
    EXPECT_EQ(read[i].frame.exposure, was.frame.exposure);
    EXPECT_EQ(read[i].frame.black_level, was.frame.black_level);
    EXPECT_EQ(read[i].frame.temperature_c, was.frame.temperature_c);
    EXPECT_EQ(read[i].frame.start, was.frame.start);
    EXPECT_EQ(read[i].monitor, was.monitor);
    EXPECT_EQ(read[i].saturated, was.saturated);
  }
  EXPECT_TRUE(frames.Of(2).empty());
}

TEST(SessionFrames, RefusesAFrameThatIsCutOff) {
  const TempDir dir;
  { EventLog log = EventLog::Create(dir / "s", SomeInfo()); }
  {
    sqlite::Database db(dir / "s" / kSessionFile, SQLITE_OPEN_READWRITE);
    db.Execute("PRAGMA foreign_keys = OFF");
    db.Execute(
        "INSERT INTO exposures VALUES (1, 1, 0.1, 0, 1, 0, 0, NULL, 4, 4, 'mono', NULL, 0, 0, 0, "
        "x'00')");
  }
  SessionFrames frames(dir / "s");
  EXPECT_THAT(MessageOf<ConfigError>([&] { (void)frames.Of(1); }),
              testing::HasSubstr("pose 1: frame 1 has 1 bytes, not 32"));
}

}  // namespace
}  // namespace gonio
