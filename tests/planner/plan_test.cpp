// SPDX-License-Identifier: Apache-2.0
// From plans to planners.
#include "planner/plan.h"

#include <gtest/gtest.h>

#include "brdf/analytic.h"
#include "core/error.h"
#include "core/file.h"
#include "tests/core/temp_dir.h"
#include "tests/fitting/small_process.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

std::string Config(const std::string& name) {
  return std::string(GONIO_SOURCE_DIR) + "/configs/" + name;
}

TEST(LoadPlan, ReadsTheDenseScan) {
  const Plan plan = LoadPlan(Config("plan-grid.yaml"));
  EXPECT_EQ(plan.name, "grid");
  EXPECT_EQ(plan.kind, PlannerKind::kGrid);
  EXPECT_EQ(plan.max_poses, 0);
  EXPECT_EQ(plan.candidates.phi, PhiChoice::kAcross);
  EXPECT_EQ(MakePlanner(plan, {})->MaxPoses(), 8100);
}

TEST(LoadPlan, ReadsTheThinnedScan) {
  const Plan plan = LoadPlan(Config("plan-thinned.yaml"));
  EXPECT_EQ(plan.kind, PlannerKind::kGrid);
  EXPECT_EQ(plan.raster.every_theta_h, 3);
  EXPECT_EQ(plan.raster.every_theta_d, 1);
  EXPECT_EQ(MakePlanner(plan, {})->MaxPoses(), 2700);
}

TEST(LoadPlan, ReadsTheRandomPlan) {
  const Plan plan = LoadPlan(Config("plan-random.yaml"));
  EXPECT_EQ(plan.kind, PlannerKind::kRandom);
  EXPECT_EQ(plan.max_poses, 100);
  EXPECT_EQ(MakePlanner(plan, {})->MaxPoses(), 100);
}

TEST(LoadPlan, ReadsTheInformationPlanAndKeepsItsText) {
  const std::string path = Config("plan-information.yaml");
  const Plan plan = LoadPlan(path);
  EXPECT_EQ(plan.kind, PlannerKind::kInformation);
  EXPECT_EQ(plan.max_poses, 100);
  EXPECT_EQ(plan.prior.name, "generic");
  EXPECT_EQ(plan.text, ReadTextFile(path));
  EXPECT_NO_THROW(plan.fit.Check());
  EXPECT_EQ(MakePlanner(plan, {})->MaxPoses(), 100);
}

TEST(LoadPlan, LooksForPriorFilesBesideThePlan) {
  const TempDir dir;
  Prior prior = GenericPrior({.lobes = 1, .knots = 4});
  prior.name = "learned";
  WritePrior(dir / "prior.yaml", prior);
  const auto path = dir.File(
      "plan.yaml",
      "version: 1\nname: x\nplanner: information\nmax_poses: 5\nfit: {prior: prior.yaml}\n");
  const Plan plan = LoadPlan(path);
  EXPECT_EQ(plan.prior.name, "learned");
  EXPECT_EQ(plan.prior.shape, (DsbrdfShape{1, 4}));
}

TEST(Plan, BelievesInAProcessUnlessItAsksForADsbrdf) {
  const std::string text = "version: 1\nname: x\nplanner: information\nmax_poses: 5\nfit: {model: ";
  Plan process = ParsePlan(text + "process}\n", "plan.yaml");
  Plan dsbrdf = ParsePlan(text + "dsbrdf}\n", "plan.yaml");
  for (Plan* plan : {&process, &dsbrdf}) plan->Believe(SmallProcessPrior());
  EXPECT_NE(process.prior.process, nullptr);
  EXPECT_EQ(dsbrdf.prior.process, nullptr);
  EXPECT_EQ(dsbrdf.prior.mean, process.prior.mean);
  EXPECT_THROW(ParsePlan(text + "gp}\n", "plan.yaml"), ConfigError);
}

TEST(ParsePlan, TakesEveryKey) {
  const Plan plan = ParsePlan(R"(
version: 1
name: all
planner: information
max_poses: 7
candidates: {theta_h_count: 11, theta_d_count: 12, spacing: uniform, phi_d: across,
             phi_span_deg: 45, max_polar_deg: 70}
information: {objective: relative, target_error: 0.5, min_gain: 0.25, max_polar_deg: 60,
              relative_noise: 0.125, repeat_length: 0.375}
fit: {lobes: 2, knots: 5, prior: generic, floor_per_sr: 0.0625, huber: 3, model_error: 0.1875,
      model_error_weight: 9, max_iterations: 77}
)",
                              "plan.yaml");
  EXPECT_EQ(plan.candidates.theta_h_count, 11);
  EXPECT_EQ(plan.candidates.theta_d_count, 12);
  EXPECT_FALSE(plan.candidates.merl_spacing);
  EXPECT_EQ(plan.candidates.phi, PhiChoice::kAcross);
  EXPECT_DOUBLE_EQ(plan.candidates.phi_span, RadFromDeg(45));
  EXPECT_DOUBLE_EQ(plan.candidates.max_polar, RadFromDeg(70));
  EXPECT_EQ(plan.information.gain.objective, Objective::kRelative);
  EXPECT_EQ(plan.information.target_error, 0.5);
  EXPECT_EQ(plan.information.min_gain, 0.25);
  EXPECT_DOUBLE_EQ(plan.information.gain.max_polar, RadFromDeg(60));
  EXPECT_EQ(plan.information.gain.relative_noise, 0.125);
  EXPECT_EQ(plan.information.gain.repeat_length, 0.375);
  EXPECT_EQ(plan.prior.shape, (DsbrdfShape{2, 5}));
  EXPECT_EQ(plan.fit.floor, 0.0625);
  EXPECT_EQ(plan.fit.huber, 3);
  EXPECT_EQ(plan.fit.model_error, 0.1875);
  EXPECT_EQ(plan.fit.model_error_weight, 9);
  EXPECT_EQ(plan.fit.max_iterations, 77);
}

TEST(ParsePlan, FillsInTheDefaults) {
  const Plan plan = ParsePlan("version: 1\nname: x\nplanner: random\n", "plan.yaml");
  EXPECT_EQ(plan.max_poses, 0);
  EXPECT_EQ(plan.candidates.theta_h_count, CandidateOptions{}.theta_h_count);
  EXPECT_NEAR(plan.candidates.max_polar, CandidateOptions{}.max_polar, 1e-15);
  EXPECT_EQ(plan.prior.shape, DsbrdfShape{});
  EXPECT_EQ(plan.fit.huber, FitOptions{}.huber);
  EXPECT_EQ(plan.fit.floor, FitOptions{}.floor);
}

TEST(MakePlanner, RefusesARigThatReachesNothing) {
  for (const char* name :
       {"plan-grid.yaml", "plan-thinned.yaml", "plan-random.yaml", "plan-information.yaml"}) {
    const Plan plan = LoadPlan(Config(name));
    EXPECT_EQ(MessageOf<ConfigError>([&] {
                MakePlanner(plan, {.reachable = [](const DirectionPair&) { return false; }});
              }),
              "plan " + plan.name +
                  ": the rig cannot reach any of its poses: check the rig's axis limits, "
                  "geometry.max_polar_deg and geometry.min_separation_deg");
  }
}

TEST(MakePlanner, ProposesNothingOutOfReach) {
  const auto reachable = [](const DirectionPair& pair) {
    return AngleBetween(pair.wi, pair.wo) > RadFromDeg(20);
  };
  for (const char* name : {"plan-grid.yaml", "plan-random.yaml"}) {
    const auto planner = MakePlanner(LoadPlan(Config(name)), {.reachable = reachable});
    while (const auto next = planner->Next()) {
      EXPECT_TRUE(reachable(next->directions));
      planner->Observe(*next, {});
    }
  }
}

TEST(MakePlanner, GivesTheRandomPlanItsSeed) {
  const Plan plan = LoadPlan(Config("plan-random.yaml"));
  const auto first = [&](std::uint64_t seed) {
    return MakePlanner(plan, {.seed = seed})->Next()->candidate;
  };
  EXPECT_EQ(first(1), first(1));
  EXPECT_NE(first(1), first(2));
}

TEST(MakePlanner, PutsTheBudgetIntoTheRaster) {
  Plan plan = LoadPlan(Config("plan-grid.yaml"));
  plan.max_poses = 100;
  EXPECT_EQ(MakePlanner(plan, {})->MaxPoses(), 100);
}

Plan Minimal(const std::string& kind, const std::string& rest = "") {
  return ParsePlan("version: 1\nname: x\nplanner: " + kind + "\n" + rest, "plan.yaml");
}

TEST(ParsePlan, KnowsTheOtherPlannersAndTheirKeys) {
  EXPECT_EQ(Minimal("nielsen").kind, PlannerKind::kNielsen);
  EXPECT_EQ(Minimal("hierarchical").kind, PlannerKind::kHierarchical);
  EXPECT_EQ(Minimal("pivoted-qr", "max_poses: 9\n").max_poses, 9);
  EXPECT_EQ(Minimal("frost", "max_poses: 9\n").kind, PlannerKind::kFrost);
  const Plan slices =
      Minimal("slices", "slices: {floor_per_sr: 0.5, curiosity: 0.25, borrowed: 0.75}\n");
  EXPECT_EQ(slices.kind, PlannerKind::kSlices);
  EXPECT_EQ(slices.slices.floor, 0.5);
  EXPECT_EQ(slices.slices.curiosity, 0.25);
  EXPECT_EQ(slices.slices.borrowed, 0.75);
  EXPECT_THROW(Minimal("frost"), ConfigError);  // its directions depend on the budget
  EXPECT_THROW(Minimal("nielsen", "slices: {curiosity: 1}\n"), ConfigError);
}

TEST(MakePlanner, SaysWhenTrainingMaterialsAreMissing) {
  for (const char* kind : {"pivoted-qr", "frost"}) {
    EXPECT_EQ(MessageOf<ConfigError>([&] { MakePlanner(Minimal(kind, "max_poses: 5\n"), {}); }),
              "plan x: its directions are computed from training materials, and none were given");
  }
}

TEST(MakePlanner, HasFiveNielsenPosesAtMost) {
  EXPECT_EQ(MakePlanner(Minimal("nielsen"), {})->MaxPoses(), 5);
  EXPECT_EQ(MakePlanner(Minimal("nielsen", "max_poses: 3\n"), {})->MaxPoses(), 3);
}

TEST(MakePlanner, GivesTheHierarchicalPlanItsTravelTime) {
  // Moving the detector is what takes time on this rig.
  const TravelTime travel = [](const DirectionPair& from, const DirectionPair& to) {
    return AngleBetween(from.wo, to.wo);
  };
  const auto planner = MakePlanner(Minimal("hierarchical"), {.costs = {.travel = travel}});
  const auto first = planner->Next();
  planner->Observe(*first, {});
  const auto second = planner->Next();
  EXPECT_DOUBLE_EQ(second->score, -travel(first->directions, second->directions));
}

// The process is offered other phi_d than the plan itself: its candidates are checked by
// themselves.
TEST(MakePlanner, RefusesAProcessWithoutCandidates) {
  Plan plan = LoadPlan(Config("plan-information.yaml"));
  auto process = std::make_shared<ProcessPrior>();
  const int size = process->basis.size();
  process->mean.setZero(size);
  process->luminance = process->chroma = Eigen::MatrixXd::Constant(size, 1, 0.1);
  process->stationary_luminance = process->stationary_chroma = Eigen::VectorXd::Zero(size);
  plan.prior.process = process;
  plan.candidates.theta_h_count = plan.candidates.theta_d_count = 1;
  const auto none = [](const DirectionPair&) { return false; };
  const std::string why =
      "plan information: the rig cannot reach any of its poses: check the "
      "rig's axis limits, geometry.max_polar_deg and "
      "geometry.min_separation_deg";
  EXPECT_EQ(MessageOf<ConfigError>([&] { MakePlanner(plan, {.reachable = none}); }), why);
}

TEST(OpenPrior, KnowsTheBuiltInOnesAndFiles) {
  EXPECT_EQ(OpenPrior("none", DsbrdfShape{2, 6}).name, "none");
  EXPECT_EQ(OpenPrior("none", DsbrdfShape{2, 6}).shape, (DsbrdfShape{2, 6}));
  EXPECT_EQ(OpenPrior("generic", DsbrdfShape{2, 6}).shape, (DsbrdfShape{2, 6}));
  EXPECT_EQ(MessageOf<ConfigError>([] { OpenPrior("no/prior.yaml", DsbrdfShape{}); }),
            "no/prior.yaml: cannot read: No such file or directory");
}

}  // namespace
}  // namespace gonio
