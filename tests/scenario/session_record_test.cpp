// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session_record.h"

#include <gmock/gmock.h>

#include "acquisition/event_log_sqlite.h"
#include "tests/core/temp_dir.h"
#include "tests/scenario/bench.h"

namespace gonio {
namespace {

using testing::HasSubstr;

TEST(SessionRecord, GivesBackWhatWasFrozenAtTheStart) {
  const TempDir dir;
  SessionInfo info = SomeInfo();
  info.material_path = "/some/where.binary";
  info.material_sha256 = "ab";
  info.prior_spec = "generic";
  info.imported = {{"file", "scan.csv"}, {"sha256", "cd"}};
  { EventLog log = EventLog::Create(dir / "s", info); }
  const SessionRecord session = ReadSession(dir / "s");
  EXPECT_EQ(session.info.seed, info.seed);
  EXPECT_EQ(session.info.max_poses, 7);
  EXPECT_EQ(session.info.rig_text, info.rig_text);
  EXPECT_EQ(session.info.plan_text, info.plan_text);
  EXPECT_EQ(session.info.prior_spec, "generic");
  EXPECT_EQ(session.info.imported, info.imported);
  EXPECT_EQ(session.info.material_path, info.material_path);
  EXPECT_EQ(session.info.devices, info.devices);
  EXPECT_THAT(session.info.created_utc, testing::MatchesRegex("....-..-..T..:..:..Z"));
  ASSERT_EQ(session.events.size(), 1u);
  EXPECT_EQ(session.events[0].kind, "session_start");
  EXPECT_TRUE(session.poses.empty());
}

TEST(SessionRecord, GivesBackHowTheSessionEnded) {
  const TempDir dir;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  ASSERT_TRUE(log.AppendEnd(Seconds(9), {"stopped", "by the user", 3, 1, Seconds(8.5), 0.25}).ok());
  const SessionRecord session = ReadSession(dir / "s");
  ASSERT_TRUE(session.end.has_value());
  EXPECT_EQ(session.end->outcome, "stopped");
  EXPECT_EQ(session.end->reason, "by the user");
  EXPECT_EQ(session.end->poses, 3);
  EXPECT_EQ(session.end->rejected, 1);
  EXPECT_EQ(session.end->duration, Seconds(8.5));
  EXPECT_EQ(session.end->predicted_error, 0.25);
}

TEST(SessionRecord, SaysWhyAPathIsNoSession) {
  const TempDir dir;
  const auto message = [](const std::filesystem::path& path) {
    return MessageOf<ConfigError>([&] { (void)ReadSession(path); });
  };
  EXPECT_EQ(message(dir / "no"), (dir / "no").string() + ": is not a session: no such directory");
  EXPECT_EQ(message(dir.path()), dir.path().string() + ": is not a session: has no session.sqlite");
  dir.File(kSessionFile, std::string(5000, 'x'));
  EXPECT_THAT(message(dir.path()), HasSubstr("not a database"));
}

TEST(SessionRecord, RefusesAnotherProgramsDatabase) {
  const TempDir dir;
  {
    sqlite::Database db(dir / kSessionFile, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
    db.Execute("CREATE TABLE t (a)");
  }
  EXPECT_THAT(MessageOf<ConfigError>([&] { (void)ReadSession(dir.path()); }),
              HasSubstr("some other program"));
}

// What the second format did not have is taken away.
TEST(SessionRecord, ReadsTheFormatBefore) {
  const TempDir dir;
  Bench bench;
  {
    EventLog log = EventLog::Create(dir / "s", SomeInfo());
    ScriptedPlanner planner({Degrees(5, 20)});
    bench.Run(planner, &log);
  }
  const SessionRecord now = ReadSession(dir / "s");
  {
    sqlite::Database db(dir / "s" / kSessionFile, SQLITE_OPEN_READWRITE);
    db.Execute(
        "DROP VIEW measurements; DROP TRIGGER meta_refuse_DELETE;"
        "DELETE FROM meta WHERE key = 'calibrations';"
        "ALTER TABLE samples DROP COLUMN sigma_systematic_red;"
        "ALTER TABLE samples DROP COLUMN sigma_systematic_green;"
        "ALTER TABLE samples DROP COLUMN sigma_systematic_blue;"
        "ALTER TABLE exposures DROP COLUMN colour; PRAGMA user_version = 2");
  }
  const SessionRecord before = ReadSession(dir / "s");
  ASSERT_EQ(before.poses.size(), 1u);
  EXPECT_TRUE((before.poses[0].samples[0].f_r == now.poses[0].samples[0].f_r).all());
  EXPECT_TRUE((before.poses[0].systematic[0] == 0).all());
  EXPECT_TRUE(before.info.calibrations.empty());
}

TEST(SessionRecord, RefusesAnotherFormatVersion) {
  const TempDir dir;
  { EventLog log = EventLog::Create(dir / "s", SomeInfo()); }
  {
    sqlite::Database db(dir / "s" / kSessionFile, SQLITE_OPEN_READWRITE);
    db.Execute("PRAGMA user_version = 99");
  }
  EXPECT_THAT(MessageOf<ConfigError>([&] { (void)ReadSession(dir / "s"); }),
              HasSubstr("has session format 99, this program reads formats 1 to 4"));
}

TEST(SessionRecord, RefusesADamagedFile) {
  const TempDir dir;
  { EventLog log = EventLog::Create(dir / "s", SomeInfo()); }
  const auto file = dir / "s" / kSessionFile;
  std::string bytes = ReadTextFile(file);
  for (std::size_t i = 4096; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 31);
  std::ofstream(file, std::ios::binary) << bytes;
  EXPECT_THAT(MessageOf<ConfigError>([&] { (void)ReadSession(dir / "s"); }),
              HasSubstr(file.string()));
}

TEST(SessionRecord, ReadsASessionThatIsStillRunning) {
  const TempDir dir;
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  ASSERT_TRUE(log.AppendNote(Seconds(1), "prepared", "homed").ok());
  const SessionRecord session = ReadSession(dir / "s");
  EXPECT_EQ(session.events.size(), 2u);
  EXPECT_FALSE(session.end.has_value());
  ASSERT_TRUE(log.AppendNote(Seconds(2), "note", "the writer goes on").ok());
}

}  // namespace
}  // namespace gonio
