// SPDX-License-Identifier: Apache-2.0
#include "acquisition/event_log.h"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <limits>

#include "acquisition/event_log_sqlite.h"
#include "acquisition/session_record.h"
#include "tests/core/temp_dir.h"
#include "tests/scenario/bench.h"

namespace gonio {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

PoseRecord SomeRecord() {
  PoseRecord record;
  record.commanded = {0.1, 0.2, 0.3, 0.4};
  record.readback = {0.1000001, 0.2, 0.3, 0.4};
  record.move_retries = 1;
  record.start = Seconds(1);
  record.move_time = Seconds(2);
  record.end = Seconds(4.5);
  Exposure exposure;
  exposure.frame = {.width = 1,
                    .height = 2,
                    .counts = {0, 1, 258, 4095, 65535, 3},
                    .exposure = Seconds(0.25),
                    .gain_db = 6,
                    .black_level = 64,
                    .start = Seconds(3)};
  exposure.monitor = 0.99;
  exposure.saturated = {false, true, false};
  record.exposures = {exposure, exposure};
  return record;
}

PoseNote SomeNote(int pose) {
  return {pose, {ToDirections(Degrees(30, 40)), 17, 2.5, "information"}, 0.125, {}};
}

BrdfSample SomeSample() {
  return {ToDirections(Degrees(29.9, 40.1)), Rgb(0.1, 1.0 / 3, -1e-7),
          Rgb(0.001, 0.002, std::numeric_limits<double>::infinity())};
}

TEST(EventLog, KeepsAPoseAndItsSampleToTheLastBit) {
  const TempDir dir;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  ASSERT_TRUE(log.AppendPose(SomeNote(1), SomeRecord()).ok());
  UncertaintyBudget budget;
  budget[UncertaintyTerm::kFlat] = Rgb(0.003, 0, 0);
  budget[UncertaintyTerm::kResponsivity] = Rgb(0.004, 0.5, 0);
  ASSERT_TRUE(log.AppendSamples(1, Seconds(5), {{SomeSample(), budget}}).ok());

  const SessionRecord session = ReadSession(dir / "s");
  ASSERT_EQ(session.poses.size(), 1u);
  EXPECT_NEAR(session.poses[0].systematic[0][0], 0.005, 1e-15);
  EXPECT_EQ(session.poses[0].systematic[0][1], 0.5);
  EXPECT_TRUE(std::isinf(session.poses[0].systematic[0][2])) << "it was not measured";
  EXPECT_EQ(
      session.events.back().body,
      R"({"pose":1,"sigma_per_sr":[{"flat":[0.003,0.0,null],"responsivity":[0.004,0.5,null]}]})");
  const MeasuredPose& pose = session.poses[0];
  const BrdfSample expected = SomeSample();
  EXPECT_EQ(pose.samples.front().directions.wi, expected.directions.wi);
  EXPECT_EQ(pose.samples.front().directions.wo, expected.directions.wo);
  EXPECT_TRUE((pose.samples.front().f_r == expected.f_r).all());
  EXPECT_TRUE((pose.samples.front().sigma == expected.sigma).all());
  EXPECT_EQ(pose.pose, 1);
  EXPECT_EQ(pose.candidate, 17);
  EXPECT_EQ(pose.reason, "information");
  EXPECT_EQ(pose.score, 2.5);
  EXPECT_EQ(pose.predicted_error, 0.125);
  EXPECT_EQ(pose.frames, 2);
  EXPECT_EQ(pose.move_retries, 1);
  EXPECT_EQ(pose.end, Seconds(4.5));
  EXPECT_NEAR(pose.planned.theta_h, RadFromDeg(30), 1e-12);
}

TEST(EventLog, KeepsRawCountsAsLittleEndianSixteenBit) {
  const TempDir dir;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  ASSERT_TRUE(log.AppendPose(SomeNote(1), SomeRecord()).ok());
  sqlite::Database db(log.file(), SQLITE_OPEN_READONLY);
  sqlite::Statement row(db,
                        "SELECT hex(counts), width, height, layout, saturated_green, exposure_s, "
                        "gain_db, temperature_c FROM exposures WHERE pose = 1 AND frame = 2");
  ASSERT_TRUE(row.Step());
  EXPECT_EQ(row.Text(0), "000001000201FF0FFFFF0300");
  EXPECT_EQ(row.Integer(1), 1);
  EXPECT_EQ(row.Integer(2), 2);
  EXPECT_EQ(row.Text(3), "rgb");
  EXPECT_EQ(row.Integer(4), 1);
  EXPECT_EQ(row.Real(5), 0.25);
  EXPECT_EQ(row.Real(6), 6);
  EXPECT_TRUE(row.IsNull(7));
}

// Example failure is INSERT OR REPLACE, which deletes a row without firing a DELETE trigger.
TEST(EventLog, RefusesToChangeOrDeleteAnything) {
  const TempDir dir;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  ASSERT_TRUE(log.AppendPose(SomeNote(1), SomeRecord()).ok());
  ASSERT_TRUE(log.AppendSamples(1, Seconds(1), {{SomeSample(), {}}}).ok());
  sqlite::Database db(log.file(), SQLITE_OPEN_READWRITE);
  for (const char* sql :
       {"UPDATE events SET kind = 'x'", "DELETE FROM events", "UPDATE poses SET score = 1",
        "DELETE FROM exposures", "UPDATE samples SET f_r_red = 0", "DELETE FROM samples",
        "UPDATE meta SET value = '' WHERE key = 'seed'", "DELETE FROM meta",
        "INSERT OR REPLACE INTO events VALUES (1, 0, 'x', '{}')",
        "INSERT OR REPLACE INTO meta VALUES ('seed', '2')",
        "REPLACE INTO samples SELECT * FROM samples"}) {
    EXPECT_THAT(MessageOf<sqlite::Failure>([&] { db.Execute(sql); }), HasSubstr("append-only"))
        << sql;
  }
}

TEST(EventLog, RefusesASampleWithoutItsRawRecord) {
  const TempDir dir;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  const Result<void> appended = log.AppendSamples(1, Seconds(1), {{SomeSample(), {}}});
  ASSERT_FALSE(appended.ok());
  EXPECT_EQ(appended.error().code, ErrorCode::kStorage);
  EXPECT_THAT(appended.error().message, HasSubstr("FOREIGN KEY"));
}

// Example failure is a log that is left inside the transaction, whose later appends are lost.
TEST(EventLog, AppendsTogetherAllOrNothing) {
  const TempDir dir;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  const auto pose_with_sample = [&](int pose) -> Result<void> {
    const Result<void> raw = log.AppendPose(SomeNote(pose), SomeRecord());
    if (!raw.ok()) return raw;
    return log.AppendSamples(pose, Seconds(1), {{SomeSample(), {}}});
  };
  const Result<void> failed = log.AppendTogether([&]() -> Result<void> {
    const Result<void> first = pose_with_sample(1);
    return first.ok() ? pose_with_sample(1) : first;  // there is one already
  });
  ASSERT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().code, ErrorCode::kStorage);
  EXPECT_TRUE(ReadSession(dir / "s").poses.empty());
  ASSERT_TRUE(log.AppendTogether([&] { return pose_with_sample(1); }).ok());
  ASSERT_TRUE(pose_with_sample(2).ok());
  EXPECT_EQ(ReadSession(dir / "s").poses.size(), 2u);
}

TEST(EventLog, RefusesADirectoryThatExists) {
  const TempDir dir;
  EXPECT_THAT(MessageOf<ConfigError>([&] { (void)EventLog::Create(dir.path(), SomeInfo()); }),
              StartsWith(dir.path().string() + ": exists already"));
  const auto file = dir.File("file", "precious");
  EXPECT_THAT(MessageOf<ConfigError>([&] { (void)EventLog::Create(file, SomeInfo()); }),
              StartsWith(file.string() + ": exists already"));
  EXPECT_EQ(ReadTextFile(file), "precious");
  EXPECT_EQ(dir.CountFiles(), 1u);
}

TEST(EventLog, NamesAMissingParentDirectory) {
  const TempDir dir;
  EXPECT_THAT(
      MessageOf<ConfigError>([&] { (void)EventLog::Create(dir / "no/session", SomeInfo()); }),
      HasSubstr((dir / "no").string() + " does not exist"));
}

TEST(EventLog, LeavesNothingBehindWhenTheDiskIsFullAtTheStart) {
  const TempDir dir;
  std::string message;
  {
    const FileSizeLimit full(2000);
    message = MessageOf<std::runtime_error>([&] { (void)EventLog::Create(dir / "s", SomeInfo()); });
  }
  EXPECT_THAT(message, StartsWith((dir / "s" / kSessionFile).string() + ": cannot write: "));
  EXPECT_THAT(message, Not(HasSubstr("\n")));
  EXPECT_EQ(dir.CountFiles(), 0u);
}

TEST(EventLog, KeepsWhatItHasWhenTheDiskIsFull) {
  const TempDir dir;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  ASSERT_TRUE(log.AppendPose(SomeNote(1), SomeRecord()).ok());
  ASSERT_TRUE(log.AppendSamples(1, Seconds(1), {{SomeSample(), {}}}).ok());
  PoseRecord large = SomeRecord();
  large.exposures[0].frame.counts.resize(1 << 20);
  {
    const FileSizeLimit full(1 << 20);
    const Result<void> appended = log.AppendPose(SomeNote(2), large);
    ASSERT_FALSE(appended.ok());
    EXPECT_EQ(appended.error().code, ErrorCode::kStorage);
    EXPECT_THAT(appended.error().message, StartsWith(log.file().string() + ": cannot write: "));
  }
  EXPECT_EQ(ReadSession(dir / "s").poses.size(), 1u);
  // Nothing of the failed pose is in the way of the same pose once there is room again.
  ASSERT_TRUE(log.AppendPose(SomeNote(2), large).ok());
  ASSERT_TRUE(log.AppendSamples(2, Seconds(1), {{SomeSample(), {}}}).ok());
  EXPECT_EQ(ReadSession(dir / "s").poses.size(), 2u);
}

TEST(EventLog, SurvivesBeingKilled) {
  const TempDir dir;
  const pid_t child = fork();
  if (child == 0) {
    EventLog log = EventLog::Create(dir / "s", SomeInfo());
    for (int pose = 1; pose <= 3; ++pose) {
      if (!log.AppendPose(SomeNote(pose), SomeRecord()).ok()) _exit(1);
      if (!log.AppendSamples(pose, Seconds(1), {{SomeSample(), {}}}).ok()) _exit(1);
    }
    kill(getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  const SessionRecord session = ReadSession(dir / "s");
  EXPECT_EQ(session.poses.size(), 3u);
  EXPECT_FALSE(session.end.has_value());
}

TEST(EventLog, LeavesOneFileWhenItIsClosed) {
  const TempDir dir;
  { EventLog log = EventLog::Create(dir / "s", SomeInfo()); }
  EXPECT_TRUE(std::filesystem::exists(dir / "s" / kSessionFile));
  EXPECT_FALSE(std::filesystem::exists(dir / "s/session.sqlite-wal"));
}

}  // namespace
}  // namespace gonio
