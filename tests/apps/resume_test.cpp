// SPDX-License-Identifier: Apache-2.0
// gonio run --resume and gonio replay, as users meet them. What happens when a process is killed is
// in tests/kill.

#include <nlohmann/json.hpp>

#include "acquisition/event_log_sqlite.h"
#include "acquisition/session_record.h"
#include "core/dir_lock.h"
#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Resume : public GonioTest {
 protected:
  // A session of eight poses that was stopped by a full disk after some of them.
  void Interrupt(const std::string& arguments) {
    const Finished full = Shell(
        "trap '' XFSZ; ulimit -f 340; \"$GONIO\" run --max-poses 8 --quiet "
        "--out s " +
        arguments);
    ASSERT_EQ(full.code, 1) << full.err;
    const SessionRecord record = ReadSession(work() / "s");
    ASSERT_GT(record.poses.size(), 1u);
    ASSERT_LT(record.poses.size(), 8u);
  }

  // What no log lets anybody do.
  void Tamper(const std::string& sql) {
    sqlite::Database db(work() / "s/session.sqlite", SQLITE_OPEN_READWRITE);
    db.Execute("DROP TRIGGER poses_refuse_UPDATE; DROP TRIGGER exposures_refuse_UPDATE");
    db.Execute(sql.c_str());
  }
};

TEST_F(Resume, GoesOnAndFits) {
  Interrupt("");
  const std::size_t before = ReadSession(work() / "s").poses.size();
  const Finished finished = Expect("run --resume s");
  EXPECT_THAT(finished.out,
              AllOf(HasSubstr(fmt::format("going on with    s: {} poses measured", before)),
                    HasSubstr("complete: pose budget reached"), HasSubstr("8 measured")));
  const SessionRecord record = ReadSession(work() / "s");
  EXPECT_EQ(record.poses.size(), 8u);
  for (std::size_t i = 1; i < record.events.size(); ++i) {
    EXPECT_GE(record.events[i].time, record.events[i - 1].time);
  }
  EXPECT_THAT(Expect("replay s").out, HasSubstr("8: all as logged"));
  EXPECT_THAT(Expect("report s").out, HasSubstr("report.html"));
}

TEST_F(Resume, RefusesAFileThatHasChangedAndShowsHow) {
  const std::string plan = Config("plan-information.yaml");
  File("p.yaml", plan);
  Interrupt("--plan p.yaml");
  File("p.yaml", With(plan, "name: information", "name: otherwise"));
  const Finished refused = Gonio("run --resume s");
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err,
              AllOf(HasSubstr("p.yaml:\n"), HasSubstr("name: information"), HasSubstr("+ "),
                    HasSubstr("name: otherwise"), HasSubstr("--accept-changed")));
  const Finished accepted = Gonio("run --quiet --resume s --accept-changed");
  EXPECT_EQ(accepted.code, 0) << accepted.err;
  EXPECT_EQ(LatestInfo(ReadSession(work() / "s")).plan_text, ReadTextFile(work() / "p.yaml"));
  EXPECT_THAT(Expect("replay s").out, HasSubstr("all as logged"));
}

// The plan's list of poses is another: what was measured is learned, and not measured again.
TEST_F(Resume, GoesOnWithAnotherPlanIfItMay) {
  File("p.yaml", Config("plan-information.yaml"));
  Interrupt("--plan p.yaml");
  File("p.yaml", Config("plan-random.yaml"));
  const Finished accepted = Gonio("run --quiet --max-poses 12 --resume s --accept-changed");
  EXPECT_EQ(accepted.code, 0) << accepted.err;
  EXPECT_THAT(accepted.out, HasSubstr("every planned pose was visited"));
  EXPECT_THAT(Expect("replay s").out, HasSubstr("all as logged"));
}

TEST_F(Resume, GoesOnWithALargerBudgetIfItMay) {
  Expect("run --max-poses 4 --quiet --out s");
  ExpectRefused(Gonio("run --resume s"), 2, {"is complete", "--max-poses"});
  EXPECT_EQ(Gonio("run --quiet --max-poses 6 --resume s").code, 2);
  const Finished accepted = Gonio("run --quiet --max-poses 6 --resume s --accept-changed");
  EXPECT_EQ(accepted.code, 0) << accepted.err;
  EXPECT_EQ(ReadSession(work() / "s").poses.size(), 6u);
  EXPECT_THAT(Expect("replay s").out, HasSubstr("6: all as logged"));
}

TEST_F(Resume, EndsIfTheSampleIsAnother) {
  const std::string grey =
      "version: 1\nname: grey\nlayers:\n  - {kind: lambert, albedo: [0.5, 0.5, 0.5]}\n";
  File("m.yaml", grey);
  Interrupt("--material m.yaml");
  File("m.yaml", With(grey, "[0.5, 0.5, 0.5]", "[0.3, 0.3, 0.3]"));
  const Finished refused = Gonio("run --resume s");
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("m.yaml: its SHA-256 was")));
  const Finished other = Gonio("run --quiet --resume s --accept-changed");
  EXPECT_EQ(other.code, 4);
  EXPECT_THAT(other.err, HasSubstr("something has changed"));
  EXPECT_EQ(Gonio("run --quiet --resume s --accept-changed --max-reference-change-percent 60").code,
            0);
}

TEST_F(Resume, LeavesASessionAloneThatAnotherProcessWrites) {
  Interrupt("");
  const DirLock other(work() / "s");
  ExpectRefused(Gonio("run --resume s"), 2, {"s: another program is writing to it"});
}

TEST_F(Resume, RefusesWhatIsNoSession) {
  ExpectRefused(Gonio("run --resume nothing"), 2, {"nothing: is not a session"});
  std::filesystem::create_directory(work() / "empty");
  ExpectRefused(Gonio("run --resume empty"), 2, {"has no session.sqlite"});
  File("empty/session.sqlite", "");
  ExpectRefused(Gonio("run --resume empty"), 2, {"holds nothing yet"});
  EXPECT_NE(Gonio("run --resume s --out t").code, 0);
}

TEST_F(Resume, ReplayFindsADecisionThatIsNotThePlanners) {
  Expect("run --max-poses 10 --quiet --out s");
  Tamper("UPDATE poses SET candidate = candidate + 1 WHERE pose = 9");
  const Finished replay = Gonio("replay s --json -");
  EXPECT_EQ(replay.code, 1);
  EXPECT_THAT(replay.out, AllOf(HasSubstr("turn 9: the log has candidate"),
                                HasSubstr("the planner now wants candidate")));
}

TEST_F(Resume, ReplayMakesSamplesFromTheFrames) {
  Expect("run --max-poses 6 --quiet --out s");
  EXPECT_THAT(Expect("replay s --rereduce --refit --out o").out,
              AllOf(HasSubstr("6 samples, 6 as they were to the last bit"),
                    HasSubstr("MALE             0 against the session's fit")));
  EXPECT_TRUE(std::filesystem::exists(work() / "o/samples.csv"));
  EXPECT_TRUE(std::filesystem::exists(work() / "o/fit.yaml"));
  Tamper("UPDATE exposures SET monitor = monitor * 1.1 WHERE pose = 2");
  EXPECT_THAT(Expect("replay s --rereduce").out, HasSubstr("5 as they were to the last bit"));
}

TEST_F(Resume, ReplaySaysWhatAnotherPlanWouldHaveChosen) {
  Expect("run --max-poses 10 --quiet --out s");
  const Finished replay = Expect("replay s --plan plan-random.yaml --out o --json o.json");
  EXPECT_THAT(replay.out, HasSubstr("what its estimate says there: no measurement"));
  const json other = json::parse(ReadTextFile(work() / "o.json"))["other_plan"];
  EXPECT_EQ(other["readings"].get<int>() + other["estimates"].get<int>(),
            other["poses"].get<int>());
  EXPECT_GT(other["duration_s"].get<double>(), 60);
  // The plan it was run with reads what it read.
  const Finished same = Expect("replay s --plan plan-information.yaml --json s.json");
  EXPECT_GE(json::parse(ReadTextFile(work() / "s.json"))["other_plan"]["readings"].get<int>(), 8);
}

}  // namespace
}  // namespace gonio
