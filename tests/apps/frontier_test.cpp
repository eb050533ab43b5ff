// SPDX-License-Identifier: Apache-2.0
// Frontier studies, as users run them.

#include <nlohmann/json.hpp>

#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kStudy = R"(version: 1
kind: frontier
name: small
materials: ["*.yaml"]
folds: 3
budgets: [4, 12]
noise: [none]
targets: [10]
dense_method: continuous
theta_d_stride: 9
phi_stride: 45
contestants:
  - name: chosen
    plan: plan-information.yaml
    reconstruction: dsbrdf
  - name: raster
    per_budget: true
    prior: plan
    reconstruction: dsbrdf
    plan: |
      version: 1
      name: few
      planner: grid
      candidates: {theta_h_count: 20, theta_d_count: 20, phi_d: across}
)";

constexpr const char* kRun = "study s.yaml --materials data --out out";

class Frontier : public GonioTest {
 protected:
  // Five materials, so that each of three folds leaves three to learn from.
  Frontier() { WriteCoatings(); }
  json Read(const std::string& file) { return json::parse(ReadTextFile(work() / file)); }
  // The cells without the time they took.
  json Cells(const std::string& dir) {
    json cells = Read(dir + "/results.json")["cells"];
    for (json& cell : cells) cell.erase("cpu_s");
    return cells;
  }
  bool Exists(const std::string& file) { return std::filesystem::exists(work() / file); }
};

TEST_F(Frontier, ScoresEveryContestantAtEveryBudgetAndGoesOnWhereItStopped) {
  File("s.yaml", kStudy);
  // 3 folds, 5 dense fits, 5 x 2 sessions.
  EXPECT_THAT(Expect(kRun).out,
              AllOf(HasSubstr("5 materials, 18 tasks, 0 of them done before"),
                    HasSubstr("Mean MALE, cross-validated, noise none"),
                    HasSubstr("To 1.05 x the dense fit's error"), HasSubstr("Stopping at")));
  const json cells = Cells("out");
  ASSERT_EQ(cells.size(), 10u);
  for (const json& cell : cells) {
    ASSERT_EQ(cell["rows"].size(), 2u);
    const json& few = cell["rows"][0];
    const json& many = cell["rows"][1];
    EXPECT_EQ(few["budget"], 4);
    EXPECT_LE(few["poses"], 4);
    EXPECT_EQ(many["budget"], 12);
    EXPECT_GT(many["male"].get<double>(), 0);
    EXPECT_LT(many["male"].get<double>(), 0.2);
    EXPECT_GT(many["minutes"].get<double>(), few["minutes"].get<double>());
    const bool chosen = cell["contestant"] == "chosen";
    EXPECT_EQ(many["predicted_error"].is_null(), !chosen);
    EXPECT_EQ(cell["stops"].size(), chosen ? 1u : 0u);
  }
  const std::string csv = ReadTextFile(work() / "out/results.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 21);
  EXPECT_THAT(ReadTextFile(work() / "out/frontier.md"),
              HasSubstr("| contestant | n = 4 | n = 12 |\n| --- | ---: | ---: |\n| chosen | "));
  for (const char* figure : {"error-poses", "error-minutes", "predicted-error"}) {
    EXPECT_TRUE(Exists(std::string("out/figures/") + figure + ".svg")) << figure;
    EXPECT_TRUE(Exists(std::string("out/figures/") + figure + ".png")) << figure;
  }

  // One cell lost, one torn; a prior that is not what was learned.
  std::filesystem::remove(work() / "out/cells/glaze/raster-none-1.json");
  File("out/cells/paint/chosen-none-1.json", "{\"key\": ");
  File("out/priors/fold-1.yaml", "version: 1\n");
  EXPECT_THAT(Expect(std::string(kRun) + " --quiet").out, HasSubstr("18 tasks, 15 of them done"));
  EXPECT_EQ(Cells("out"), cells);
}

TEST_F(Frontier, DoesNotDependOnTheNumberOfThreads) {
  File("s.yaml", With(kStudy, "budgets: [4, 12]", "budgets: [4]"));
  Expect("study s.yaml --materials data --out one --threads 1");
  Expect("study s.yaml --materials data --out two --threads 2");
  EXPECT_EQ(Cells("one"), Cells("two"));
  EXPECT_EQ(ReadTextFile(work() / "one/results.csv"), ReadTextFile(work() / "two/results.csv"));
}

TEST_F(Frontier, LearnsAFoldFromTheOthersAndSaysFromWhat) {
  File("s.yaml", With(kStudy, "materials: [\"*.yaml\"]",
                      "materials: [\"[eglp]*\"]\nheld_out: [\"rubber*\"]"));
  File("s.yaml", With(ReadTextFile(work() / "s.yaml"), "folds: 3", "folds: 4"));
  EXPECT_THAT(Expect(kRun).out, HasSubstr("Mean MALE, held-out materials, noise none"));
  const auto taught = [&](int fold) {
    std::vector<std::string> names;
    const json record = Read("out/priors/fold-" + std::to_string(fold) + ".json");
    for (const json& material : record["materials"]) {
      EXPECT_EQ(material["sha256"].get<std::string>().size(), 64u);
      names.push_back(material["name"]);
    }
    return names;
  };
  EXPECT_THAT(taught(0), testing::ElementsAre("glaze", "lacquer", "paint"));
  EXPECT_THAT(taught(2), testing::ElementsAre("enamel", "glaze", "paint"));
  EXPECT_THAT(taught(4), testing::ElementsAre("enamel", "glaze", "lacquer", "paint"));
}

TEST_F(Frontier, RefusesAPriorThatHasSeenAMaterial) {
  // The prior of fold 0 has seen all but enamel and paint.
  File("s.yaml", kStudy);
  Expect(kRun);
  std::filesystem::copy(work() / "out/priors/fold-0.yaml", work() / "seen.yaml");
  std::string yaml =
      With(kStudy, "phi_d: across}", "phi_d: across}\n      fit: {prior: seen.yaml}");
  File("s.yaml", yaml);
  ExpectRefused(Gonio("study s.yaml --materials data --out other"), 2,
                {"glaze: the prior \"fold 0\" has seen it"});
  EXPECT_FALSE(Exists("other/cells"));
}

TEST_F(Frontier, RefusesTheSameContentUnderAnotherName) {
  File("s.yaml", kStudy);
  File("data/twin.yaml", ReadTextFile(work() / "data/paint.yaml"));
  ExpectRefused(Gonio(kRun), 2, {"twin.yaml: has the same content as ", "paint.yaml"});
}

TEST_F(Frontier, IsStoppedAfterTheTasksInHand) {
  File("s.yaml", kStudy);
  const Finished stopped = Shell(
      "\"$GONIO\" study s.yaml --materials data --out out --threads 1 & pid=$!; "
      "until ls out/cells/*/dense.json >/dev/null 2>&1 || ! kill -0 $pid; do :; done; kill -INT "
      "$pid; wait $pid");
  EXPECT_EQ(stopped.code, 3);
  EXPECT_THAT(stopped.out, HasSubstr("stopped; the same command goes on from here"));
  EXPECT_THAT(Expect(kRun).out, AllOf(HasSubstr("18 tasks, "), Not(HasSubstr("18 tasks, 0 of"))));
}

TEST_F(Frontier, GoesOnAfterAContestantThatFails) {
  // No pose of this rig is within reach of the raster's only cell.
  File("s.yaml", With(kStudy, "{theta_h_count: 20, theta_d_count: 20, phi_d: across}",
                      "{theta_h_count: 1, theta_d_count: 1, phi_d: across}"));
  File("rig.yaml", With(Config("sim-rig.yaml"), "max_polar_deg: 86", "max_polar_deg: 20"));
  File("s.yaml", "rig: rig.yaml\n" + ReadTextFile(work() / "s.yaml"));
  const Finished run = Gonio(kRun);
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("rubber, raster, noise none: plan few: the rig cannot reach "
                                 "any of its poses"));
  EXPECT_THAT(run.out, HasSubstr("failed           5 of 18 tasks"));
}

TEST_F(Frontier, LetsRivalsPlayWithWhatTheOtherFoldsTaught) {
  std::string yaml = kStudy;
  const std::string tail = "\n    prior: plan\n    plan: |\n      version: 1\n      name: x\n";
  for (const char* rival : {"pivoted-qr", "frost", "nielsen"}) {
    yaml += std::string("  - name: ") + rival + "\n    reconstruction: pca" + tail +
            "      planner: " + rival + "\n      max_poses: 5\n";
  }
  for (const char* rival : {"slices", "hierarchical"}) {
    yaml += std::string("  - name: ") + rival + "\n    reconstruction: scattered" + tail +
            "      planner: " + rival + "\n";
  }
  File("s.yaml", yaml);
  Expect(kRun);
  const json cells = Cells("out");
  ASSERT_EQ(cells.size(), 35u);
  for (const json& cell : cells) {
    const json& many = cell["rows"][1];
    EXPECT_EQ(many["poses"], cell["contestant"] == "nielsen" ? 5 : 12) << cell["contestant"];
    EXPECT_LT(many["male"].get<double>(), 0.2) << cell["contestant"];
  }
}

TEST_F(Frontier, RefusesFilesThatAreWrong) {
  const auto refuse = [&](const std::string& from, const std::string& to, const std::string& why) {
    File("s.yaml", With(kStudy, from, to));
    ExpectRefused(Gonio(kRun), 2, {"s.yaml", why});
    EXPECT_FALSE(Exists("out"));
  };
  refuse("kind: frontier", "kind: front", "kind: is \"front\", must be one of thinning, frontier");
  refuse("budgets: [4, 12]", "budgets: [12, 4]", "budgets: must ascend: 4 comes after 12");
  refuse("budgets: [4, 12]", "budgets: [0]", "budgets");
  refuse("folds: 3", "folds: 6", "folds: is 6, but there are only 5 materials");
  refuse("folds: 3", "folds: 1", "folds: is 1, must be >= 2");
  refuse("materials: [\"*.yaml\"]", "materials: []", "materials: is empty");
  refuse("materials: [\"*.yaml\"]", "materials: [\"*.bsdf\"]", "materials: none found in data");
  refuse("noise: [none]", "noise: [some]", "noise: holds \"some\", must be of none, default");
  refuse("    per_budget: true", "    per_budgets: true", "per_budgets");
  refuse("name: raster", "name: chosen", "there are two called \"chosen\"");
  refuse("name: raster", "name: a/b", "must be of letters");
  refuse("targets: [10]", "targets: [-1]", "targets");
  refuse("planner: grid", "planner: none", "plan of raster");
  File("s.yaml", With(kStudy, "folds: 3", "folds: 3\nextra_training: [\"paint*\"]"));
  ExpectRefused(Gonio(kRun), 2, {"paint.yaml: has the same name as", "either scored, or"});
}

}  // namespace
}  // namespace gonio
