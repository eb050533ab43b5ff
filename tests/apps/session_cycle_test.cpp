// SPDX-License-Identifier: Apache-2.0
// What users do: run, export, compare, fit, simulate.

#include <nlohmann/json.hpp>

#include "acquisition/event_log_sqlite.h"
#include "acquisition/session_record.h"
#include "brdf/merl_table.h"
#include "brdf/samples_csv.h"
#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class SessionCycle : public GonioTest {
 protected:
  json Compare(const std::string& reference, const std::string& other) {
    Expect(fmt::format("compare {} {} --json m.json --phi-stride 4", reference, other));
    return json::parse(ReadTextFile(work() / "m.json"));
  }
};

// The session is then its process: better than its own DSBRDF fit.
TEST_F(SessionCycle, LearnsAPriorAndMeasuresWithIt) {
  Expect("prior learn satin-paint.yaml glossy-plastic.yaml retro-cloth.yaml --out mine.yaml");
  const std::string summary =
      Gonio("run --material satin-paint.yaml --prior mine.yaml --max-poses 20 --out s").out;
  EXPECT_THAT(summary, HasSubstr("the process of prior mine"));
  const std::string material =
      std::string(GONIO_SOURCE_DIR) + "/configs/materials/satin-paint.yaml";
  const double male = Compare(material, "s")["male"];
  EXPECT_LT(male, Compare(material, "s/fit.yaml")["male"].get<double>());
  EXPECT_LT(male, 0.01);
  ExpectRefused(Gonio("prior learn satin-paint.yaml --out mine.yaml"), 2, {"mine.yaml", "exists"});
  ExpectRefused(Gonio("prior learn satin-paint.yaml --out other.yaml"), 2, {"3 materials or more"});
}

TEST_F(SessionCycle, RunsExportsComparesAndFitsAgain) {
  const std::string summary = Expect("run --material satin-paint.yaml --max-poses 40 --out s").out;
  EXPECT_THAT(summary, AllOf(HasSubstr("measuring: pose 40 of 40"), HasSubstr("MALE"),
                             HasSubstr("dense scan"), HasSubstr("complete: pose budget reached")));

  Expect("export s --to merl s.binary");
  ASSERT_EQ(std::filesystem::file_size(work() / "s.binary"), MerlTable::kFileBytes);
  const MerlTable table = MerlTable::Open(work() / "s.binary");
  for (int h = 0; h < MerlTable::kThetaH; h += 3) {
    for (int d = 0; d < MerlTable::kThetaD; ++d) {
      for (int p = 0; p < MerlTable::kPhiD; p += 3) {
        const bool above = ToDirections(MerlTable::CellCentre(h, d, p)).above_horizon();
        ASSERT_EQ(table.Cell(h, d, p).has_value(), above) << h << " " << d << " " << p;
      }
    }
  }

  const std::string material =
      std::string(GONIO_SOURCE_DIR) + "/configs/materials/satin-paint.yaml";
  const double male = Compare(material, "s.binary")["male"];
  EXPECT_LT(male, 0.05);
  // The table, the fit file and the session are the same reflectance.
  EXPECT_LT(Compare("s.binary", "s/fit.yaml")["male"].get<double>(), 1e-12);
  EXPECT_NEAR(Compare(material, "s")["male"].get<double>(), male, 1e-12);

  Expect("export s --to csv s.csv");
  EXPECT_EQ(ReadSamplesCsv(work() / "s.csv").size(), 40u);
  Expect("fit s.csv --out again.yaml");
  EXPECT_LT(Compare("s/fit.yaml", "again.yaml")["male"].get<double>(), 0.02);
  EXPECT_THAT(Expect("fit s.binary --out dense.yaml").out, HasSubstr("MALE"));
  Expect("export dense.yaml --to merl dense.binary");
  Expect("fit s --out same.yaml");
  EXPECT_THAT(Files(), ElementsAre("again.yaml", "dense.binary", "dense.yaml", "m.json", "s",
                                   "s.binary", "s.csv", "same.yaml"));
}

TEST_F(SessionCycle, TheSameSeedGivesTheSamePosesAndFit) {
  for (const char* run : {"--seed 7 --out a", "--seed 7 --out b --quiet", "--seed 8 --out c"}) {
    Expect(std::string("run --max-poses 15 ") + run);
  }
  for (const char* s : {"a", "b", "c"}) Expect(fmt::format("export {0} --to csv {0}.csv", s));
  EXPECT_EQ(ReadTextFile(work() / "a/fit.yaml"), ReadTextFile(work() / "b/fit.yaml"));
  const auto rows = [&](const std::string& name) {
    const std::string text = ReadTextFile(work() / name);
    return text.substr(text.find("\npose"));  // the comments tell the date
  };
  EXPECT_EQ(rows("a.csv"), rows("b.csv"));
  EXPECT_NE(rows("a.csv"), rows("c.csv"));
}

// The session's clock is virtual: an hour's wait is over at once.
TEST_F(SessionCycle, AnOpenDoorSuspendsAndAClosedOneLetsItGoOn) {
  File("rig.yaml", Config("sim-rig.yaml") +
                       "\ninterlocks:\n  signals:\n"
                       "    - {name: door, signal: file, file: door, min: 1, hold_s: 2}\n");
  File("door", "0\n");
  const Finished open = Gonio("run --rig rig.yaml --max-poses 3 --quiet --out s");
  EXPECT_EQ(open.code, 4);
  EXPECT_THAT(open.err, AllOf(HasSubstr("warning: interlock door: is 0, must be >= 1"),
                              HasSubstr("suspended for 60 min")));
  File("door", "1\n");
  Expect("run --quiet --resume s");
  EXPECT_EQ(ReadSession(work() / "s").poses.size(), 3u);
  Expect("replay s");
}

TEST_F(SessionCycle, ASessionFreezesWhatItWasRunWith) {
  Expect("run --max-poses 3 --seed 5 --prior generic --quiet --out s");
  const SessionRecord session = ReadSession(work() / "s");
  EXPECT_EQ(session.info.rig_text, Config("sim-rig.yaml"));
  EXPECT_EQ(session.info.plan_text, Config("plan-information.yaml"));
  EXPECT_EQ(session.info.seed, 5u);
  EXPECT_EQ(session.info.prior_spec, "generic");
  EXPECT_EQ(session.info.material_sha256.size(), 64u);
  EXPECT_EQ(session.info.devices.size(), 7u);
  EXPECT_EQ(session.poses.size(), 3u);
  ASSERT_TRUE(session.end.has_value());
  EXPECT_EQ(session.end->outcome, "complete");
}

TEST_F(SessionCycle, ExportsASessionThatWasKilledBeforeItsFit) {
  Expect("run --max-poses 12 --quiet --out s");
  Expect("export s --to merl with.binary");
  std::filesystem::remove(work() / "s/fit.yaml");
  Expect("export s --to merl without.binary");
  EXPECT_LT(Compare("with.binary", "without.binary")["male"].get<double>(), 1e-9);
}

TEST_F(SessionCycle, RefitsAnInterruptedSessionOnlyWithThePriorItWasRunWith) {
  Expect("run --max-poses 3 --quiet --out s");
  std::filesystem::remove(work() / "s/fit.yaml");
  // A session whose prior has changed since: the hash that was logged is another one.
  sqlite::Database(work() / "s/session.sqlite", SQLITE_OPEN_READWRITE)
      .Execute(
          "DROP TRIGGER meta_refuse_UPDATE; UPDATE meta SET value = 'x' WHERE key = "
          "'prior_sha256'");
  ExpectRefused(Gonio("export s --to merl t.binary"), 2, {"prior \"generic\" is no longer"});
  EXPECT_THAT(Files(), ElementsAre("s"));
}

TEST_F(SessionCycle, CtrlCFinishesThePoseAndStopsCleanly) {
  const Finished finished = Shell(
      "\"$GONIO\" run --plan plan-grid.yaml --out s & pid=$!\n"
      "while ! test -s s/session.sqlite-wal; do sleep 0.02; done; sleep 0.2\n"
      "kill -INT $pid; wait $pid");
  EXPECT_EQ(finished.code, 3) << finished.err;
  EXPECT_THAT(finished.err, HasSubstr("stopping after this pose"));
  EXPECT_THAT(finished.out, HasSubstr("stopped: stopped by the user"));
  const SessionRecord session = ReadSession(work() / "s");
  ASSERT_TRUE(session.end.has_value());
  EXPECT_EQ(session.end->outcome, "stopped");
  EXPECT_EQ(session.end->poses, static_cast<int>(session.poses.size()));
}

TEST_F(SessionCycle, SimulatesWhatPlansWouldCost) {
  const Finished finished = Expect(
      "simulate --plan plan-information.yaml plan-random.yaml --material satin-paint.yaml "
      "glossy-plastic.yaml --max-poses 10 --seeds 2 --json m.json --quiet");
  EXPECT_THAT(finished.out, AllOf(HasSubstr("dense scan"), HasSubstr("30 % of its rows"),
                                  HasSubstr("plan-random"), Not(HasSubstr("nan"))));
  const json m = json::parse(ReadTextFile(work() / "m.json"));
  ASSERT_EQ(m["sessions"].size(), 8u);
  for (const json& session : m["sessions"]) {
    EXPECT_EQ(session["poses"], 10);
    EXPECT_GT(session["male"].get<double>(), 0);
    EXPECT_GT(session["duration_s"].get<double>(), 10);
  }
  EXPECT_GT(m["dense_scan"]["duration_s"].get<double>(), 3600);
  EXPECT_THAT(Files(), ElementsAre("m.json"));
}

// A table that ends at theta_d = 45 degrees, as measured files do somewhere: what lies beyond is
// not offered to the planner, and not taken for black.
TEST_F(SessionCycle, LeavesOutWhatASimulatedMaterialDoesNotKnow) {
  MerlTable::FromFunction("half", [](const HalfDiff& x) -> std::optional<Rgb> {
    if (x.theta_d > 0.785) return std::nullopt;
    return Rgb::Constant(0.2);
  }).Write(work() / "half.binary");
  Expect("run --material half.binary --plan plan-random.yaml --max-poses 20 --out s");
  const SessionRecord session = ReadSession(work() / "s");
  EXPECT_EQ(session.poses.size(), 20u);
  for (const MeasuredPose& pose : session.poses) {
    EXPECT_LT(ToHalfDiff(pose.samples.front().directions).theta_d, 0.8);
    EXPECT_NEAR(pose.samples.front().f_r[1], 0.2, 0.05);
  }
}

}  // namespace
}  // namespace gonio
