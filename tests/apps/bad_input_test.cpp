// SPDX-License-Identifier: Apache-2.0
// Whatever a user can get wrong: one clear line, the right exit code, nothing half-written.

#include "acquisition/session_record.h"
#include "brdf/merl_table.h"
#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class BadInput : public GonioTest {
 protected:
  // A rig file with one thing wrong is refused with its line and key, and no session is made.
  void ExpectRigRefused(const std::string& from, const std::string& to,
                        const std::vector<std::string>& words) {
    const std::string text = With(Config("sim-rig.yaml"), from, to);
    File("rig.yaml", text);
    ExpectRefused(Gonio("run --rig rig.yaml --out s"), 2, words);
    EXPECT_THAT(Files(), ElementsAre("rig.yaml"));
  }
};

TEST_F(BadInput, TruncatedMerlFile) {
  Expect("run --max-poses 3 --quiet --out s && \"$GONIO\" export s --to merl t.binary");
  std::filesystem::resize_file(work() / "t.binary", 1000000);
  for (const char* command : {"run --material t.binary --out n", "fit t.binary --out n",
                              "compare t.binary s", "compare s t.binary --json n",
                              "simulate --plan plan-random.yaml --material t.binary --json n"}) {
    ExpectRefused(Gonio(command), 2, {"t.binary", "1000000"});
  }
  std::filesystem::resize_file(work() / "t.binary", MerlTable::kFileBytes + 8);
  ExpectRefused(Gonio("run --material t.binary --out n"), 2, {"t.binary"});
  std::filesystem::resize_file(work() / "t.binary", 0);
  ExpectRefused(Gonio("fit t.binary --out n"), 2, {"t.binary"});
  EXPECT_THAT(Files(), ElementsAre("s", "t.binary"));
}

TEST_F(BadInput, MissingFiles) {
  ExpectRefused(Gonio("run --rig no.yaml --out s"), 2, {"no.yaml: no such file"});
  ExpectRefused(Gonio("run --plan no/plan.yaml --out s"), 2, {"no/plan.yaml: no such file"});
  ExpectRefused(Gonio("run --material no.binary --out s"), 2, {"no.binary"});
  ExpectRefused(Gonio("run --prior no.yaml --out s"), 2, {"no.yaml"});
  ExpectRefused(Gonio("fit no.csv --out f"), 2, {"no.csv"});
  ExpectRefused(Gonio("compare no.yaml no.yaml"), 2, {"no.yaml"});
  ExpectRefused(Gonio("export no --to csv f"), 2, {"no: is not a session"});
  ExpectRefused(Gonio("run --out no/s"), 2, {"no/s", "does not exist"});
  EXPECT_THAT(Files(), IsEmpty());
}

TEST_F(BadInput, TextWhereANumberBelongs) {
  ExpectRigRefused("settle_s: 0.5", "settle_s: fast", {"rig.yaml:", "motion.settle_s", "fast"});
  ExpectRigRefused("settle_s: 0.5", "settle_s: .nan", {"rig.yaml:", "motion.settle_s", "finite"});
  ExpectRigRefused("read_noise_e: 8  ", "read_noise_e: .inf",
                   {"rig.yaml:", "read_noise_e", "finite"});
  ExpectRigRefused("width_px: 8", "width_px: 8.5", {"rig.yaml:", "camera.width_px", "whole"});
}

TEST_F(BadInput, UnknownOrMissingKey) {
  ExpectRigRefused("settle_s: 0.5", "setle_s: 0.5", {"rig.yaml:", "motion.settle_s", "missing"});
  ExpectRigRefused("retries: 2", "retrys: 2", {"rig.yaml:", "motion.retrys", "not a known key"});
  ExpectRigRefused("simulation:", "simulacrum:", {"rig.yaml:", "simulation", "missing"});
  ExpectRigRefused("version: 1", "version: 2", {"rig.yaml:", "version"});
}

TEST_F(BadInput, LimitWithMinAboveMax) {
  ExpectRigRefused("max_deg: 185", "max_deg: -190",
                   {"rig.yaml:", "axes.light_azimuth.max_deg", "-190", "must be > min_deg"});
  ExpectRigRefused("max_exposure_s: 10", "max_exposure_s: 1.0e-9",
                   {"rig.yaml:", "camera.max_exposure_s", "must be > min_exposure_s"});
}

TEST_F(BadInput, BrokenYaml) {
  File("rig.yaml", "axes: [1, 2\n");
  ExpectRefused(Gonio("run --rig rig.yaml --out s"), 2, {"rig.yaml:", "not valid YAML"});
  File("rig.yaml", "");
  ExpectRefused(Gonio("run --rig rig.yaml --out s"), 2, {"rig.yaml:"});
  File("rig.yaml", std::string(3000, '\x01'));
  ExpectRefused(Gonio("run --rig rig.yaml --out s"), 2, {"rig.yaml"});
  EXPECT_THAT(Files(), ElementsAre("rig.yaml"));
}

TEST_F(BadInput, ARigThatReachesNoPose) {
  // Both arms can only point at the normal, where they would touch.
  std::string text = Config("sim-rig.yaml");
  text = With(text, "min_deg: 2\n    max_deg: 90", "min_deg: 89.5\n    max_deg: 90");
  text = With(text, "min_deg: 2\n    max_deg: 90", "min_deg: 89.5\n    max_deg: 90");
  File("rig.yaml", text);
  ExpectRefused(Gonio("run --rig rig.yaml --out s"), 2, {"reach"});
  EXPECT_THAT(Files(), ElementsAre("rig.yaml"));
}

TEST_F(BadInput, BadPlan) {
  File("plan.yaml",
       With(Config("plan-information.yaml"), "planner: information", "planner: oracle"));
  ExpectRefused(Gonio("run --plan plan.yaml --out s"), 2, {"plan.yaml:", "planner", "oracle"});
  File("plan.yaml", Config("plan-information.yaml") + "\nmystery: 1\n");
  ExpectRefused(Gonio("run --plan plan.yaml --out s"), 2, {"plan.yaml:", "mystery"});
  EXPECT_THAT(Files(), ElementsAre("plan.yaml"));
}

TEST_F(BadInput, BadMaterial) {
  File("m.yaml", "version: 1\nname: x\nlayers:\n  - kind: lambert\n    albedo: [0.1, .nan, 0.1]\n");
  ExpectRefused(Gonio("run --material m.yaml --out s"), 2, {"m.yaml:5:", "albedo", "finite"});
  File("m.txt", "hello");
  ExpectRefused(Gonio("run --material m.txt --out s"), 2, {"m.txt"});
  EXPECT_THAT(Files(), ElementsAre("m.txt", "m.yaml"));
}

TEST_F(BadInput, BadSamples) {
  const std::string header =
      "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,f_r_red,f_r_green,f_r_blue\n";
  File("a.csv", header + "10,0,20,180,0.1,nan,0.1\n");
  ExpectRefused(Gonio("fit a.csv --out f.yaml"), 2, {"a.csv:2:", "f_r_green", "nan"});
  File("a.csv", header + "95,0,20,180,0.1,0.1,0.1\n");
  ExpectRefused(Gonio("fit a.csv --out f.yaml"), 2, {"a.csv:2:", "theta_i_deg"});
  File("a.csv", header);
  ExpectRefused(Gonio("fit a.csv --out f.yaml"), 2, {"a.csv"});
  EXPECT_THAT(Files(), ElementsAre("a.csv"));
}

TEST_F(BadInput, BadFitFile) {
  Expect("run --max-poses 3 --quiet --out s");
  const std::string text = ReadTextFile(work() / "s/fit.yaml");
  File("f.yaml", text.substr(0, text.size() / 2));
  ExpectRefused(Gonio("compare f.yaml s"), 2, {"f.yaml"});
  ExpectRefused(Gonio("export f.yaml --to merl t.binary"), 2, {"f.yaml"});
  EXPECT_THAT(Files(), ElementsAre("f.yaml", "s"));
}

TEST_F(BadInput, OutputDirectoryThatExists) {
  Expect("run --max-poses 3 --quiet --out s");
  const std::string before = ReadTextFile(work() / "s/session.sqlite");
  ExpectRefused(Gonio("run --max-poses 3 --out s"), 2, {"s: exists already"});
  EXPECT_EQ(ReadTextFile(work() / "s/session.sqlite"), before);
  File("file", "precious");
  ExpectRefused(Gonio("run --out file"), 2, {"file: exists already"});
  EXPECT_EQ(ReadTextFile(work() / "file"), "precious");
}

TEST_F(BadInput, FullDiskWhileMeasuring) {
  // ulimit counts blocks of 512 bytes in sh: room for the tables and some poses.
  const Finished finished = Shell("ulimit -f 800; \"$GONIO\" run --quiet --out s");
  ExpectRefused(finished, 1, {"s/session.sqlite: cannot write: ", "poses are safe in s"});
  EXPECT_THAT(finished.out, IsEmpty());
  EXPECT_FALSE(std::filesystem::exists(work() / "s/fit.yaml"));
  const SessionRecord session = ReadSession(work() / "s");
  EXPECT_FALSE(session.poses.empty());
  EXPECT_THAT(finished.err, HasSubstr(fmt::format("({} poses", session.poses.size())));
}

TEST_F(BadInput, FullDiskAtTheStart) {
  ExpectRefused(Shell("ulimit -f 4; \"$GONIO\" run --out s"), 1,
                {"s/session.sqlite: cannot write: "});
  EXPECT_THAT(Files(), IsEmpty());
}

TEST_F(BadInput, FullDiskWhileExporting) {
  Expect("run --max-poses 3 --quiet --out s");
  ExpectRefused(Shell("ulimit -f 100; \"$GONIO\" export s --to merl t.binary"), 1,
                {"t.binary: cannot write: "});
  ExpectRefused(Gonio("export s --to merl no/t.binary"), 1, {"no/t.binary: cannot write: "});
  EXPECT_THAT(Files(), ElementsAre("s"));
}

TEST_F(BadInput, AFolderThatIsNoSession) {
  std::filesystem::create_directory(work() / "d");
  for (const char* command :
       {"export d --to csv f", "export d --to merl f", "compare d d", "fit d --out f"}) {
    ExpectRefused(Gonio(command), 2, {"d: is not a session"});
  }
  EXPECT_THAT(Files(), ElementsAre("d"));
}

TEST_F(BadInput, ExportOfSomethingElse) {
  File("x.csv", "a,b\n");
  ExpectRefused(Gonio("export x.csv --to merl f"), 2, {"x.csv"});
  ExpectRefused(Gonio("export x.csv --to csv f"), 2, {"x.csv"});
  EXPECT_THAT(Files(), ElementsAre("x.csv"));
}

}  // namespace
}  // namespace gonio
