// SPDX-License-Identifier: Apache-2.0
#include "planner/process_planner.h"

#include <gtest/gtest.h>

#include <set>

#include "core/units.h"
#include "tests/fitting/small_process.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

std::vector<Candidate> Candidates() {
  return MakeCandidates(
      {.theta_h_count = 16, .theta_d_count = 16, .phi_choices = 2, .phi_span = kPi}, {});
}

ProcessPlannerOptions Options(int max_poses) {
  ProcessPlannerOptions options;
  options.max_poses = max_poses;
  options.min_gain = 0;
  options.gain.targets = 200;
  options.gain.coarse = 200;
  options.prior = SmallProcessPrior().process;
  return options;
}

std::vector<Proposal> MeasureAll(Planner& planner) {
  const AnalyticBrdf material = PaintOf(0.22, 0.2);
  Random random(1, 0);
  std::vector<Proposal> proposals;
  while (const auto next = planner.Next()) {
    proposals.push_back(*next);
    planner.Observe(*next, ReadingAt(material, next->directions, 0.01, random));
  }
  return proposals;
}

TEST(ProcessGain, SupposesWhatMeasuringWouldTeach) {
  const auto model = std::make_shared<const ProcessModel>(*SmallProcessPrior().process);
  ProcessOptions process;
  process.stationary_scales = {1};
  process.scale_weight = 0;
  ProcessGainOptions options;
  options.targets = 200;
  options.coarse = 100;
  ProcessGain gain(Candidates(), options);
  gain.Learn(model, ProcessPosterior(*model, {}, process), process);
  const double before = gain.GainOf(150);
  gain.Suppose(150);
  // A second look at the same place, or beside it, teaches next to nothing.
  EXPECT_GT(before, 0.01);
  EXPECT_LT(gain.GainOf(150), 0.1 * before);
  EXPECT_LT(gain.GainOf(151), 0.3 * before);
}

TEST(ProcessGain, OfAnImageIsMoreThanThatOfItsBestPartAndLessThanTheirSum) {
  const auto model = std::make_shared<const ProcessModel>(*SmallProcessPrior().process);
  const ProcessOptions process;
  const std::vector<Candidate> candidates = Candidates();
  const std::vector<int> parts = {5, 60, 110};
  const auto gain_of = [&](PartsOf shown) {
    ProcessGainOptions options;
    options.targets = 200;
    options.parts = std::move(shown);
    ProcessGain gain(candidates, options);
    gain.Learn(model, ProcessPosterior(*model, {}, process), process);
    return gain.GainsOf({5, 60, 110, 150});
  };
  const std::vector<double> alone = gain_of({});
  const std::vector<double> same =
      gain_of([](const DirectionPair& pair) { return std::vector<DirectionPair>{pair}; });
  for (std::size_t i = 0; i < alone.size(); ++i) EXPECT_NEAR(same[i], alone[i], 5e-3 * alone[i]);
  const double image = gain_of([&](const DirectionPair& pair) {
    std::vector<DirectionPair> all = {pair};
    for (const int part : parts) all.push_back(candidates[part].directions);
    return all;
  })[3];
  EXPECT_GT(image, *std::max_element(alone.begin(), alone.end()));
  EXPECT_LT(image, std::min(1.0, 1.1 * (alone[0] + alone[1] + alone[2] + alone[3])));
}

TEST(ProcessGain, ChoosesTheSameWhetherScoredAtOnceOrInTwoSteps) {
  const auto model = std::make_shared<const ProcessModel>(*SmallProcessPrior().process);
  const ProcessOptions process;
  ProcessGainOptions options;
  options.targets = 200;
  options.coarse = 60;
  ProcessGain gain(Candidates(), options);
  gain.Learn(model, ProcessPosterior(*model, {}, process), process);
  const auto count = gain.candidates().size();
  const auto found =
      gain.Best(std::vector<bool>(count, false), [](const Candidate&, double g) { return g; });
  double best = 0;
  for (std::size_t i = 0; i < count; ++i) best = std::max(best, gain.GainOf(static_cast<int>(i)));
  EXPECT_GT(found.gain, 0.9 * best);
  EXPECT_NEAR(found.gain, gain.GainOf(found.candidate), 1e-5 * found.gain);
}

// In single precision what is known there comes out below nothing, and its root is no number.
TEST(ProcessGain, ExpectsAnErrorWhereItsTargetsAreKnownExactly) {
  const auto model = std::make_shared<const ProcessModel>(*SmallProcessPrior().process);
  ProcessOptions process;
  process.model_error = process.repeatability = 0;
  const ProcessGainOptions options = Options(1).gain;
  ProcessGain gain(Candidates(), options);
  std::vector<ProcessReading> readings;
  for (const SpreadDirection& target : SpreadDirections(options.targets, options.max_polar)) {
    if (readings.size() == 40) break;
    const ProcessModel::Place place = model->At(target.angles);
    const Rgb f_r = model->ReflectanceOf(model->transform().transpose() * place.mean);
    readings.push_back({place, f_r, 1e-9 * f_r});
  }
  gain.Learn(model, ProcessPosterior(*model, readings, process), process);
  EXPECT_GE(gain.predicted_error(), 0);
  EXPECT_LT(gain.predicted_error(), 0.1);
}

TEST(ProcessPlanner, LowersItsPredictedErrorAndEndsWithTheBudget) {
  ProcessPlanner planner(Candidates(), Options(30));
  EXPECT_FALSE(planner.PredictedError().has_value());
  ASSERT_TRUE(planner.Next().has_value());
  const std::vector<Proposal> proposals = MeasureAll(planner);
  EXPECT_EQ(proposals.size(), 30u);
  EXPECT_EQ(planner.reason(), "pose budget reached");
  EXPECT_LT(*planner.PredictedError(), 0.02);
  std::set<int> seen;
  for (const Proposal& proposal : proposals) EXPECT_TRUE(seen.insert(proposal.candidate).second);
}

TEST(ProcessPlanner, ForetellsBeforeTheFirstReading) {
  ProcessPlanner planner(Candidates(), Options(30));
  planner.Next();
  const Rgb foretold = *planner.Predict(ToDirections({0.3, 0.5, 1}));
  EXPECT_TRUE((foretold > 0.01 && foretold < 1).all());
}

TEST(ProcessPlanner, EndsAtTheTargetErrorOrSaysThatItIsOutOfReach) {
  ProcessPlannerOptions options = Options(200);
  options.target_error = 0.02;
  ProcessPlanner reachable(Candidates(), options);
  EXPECT_LT(MeasureAll(reachable).size(), 200u);
  EXPECT_EQ(reachable.reason(), "target error reached");
  options.target_error = 1e-6;
  ProcessPlanner hopeless(Candidates(), options);
  EXPECT_LT(MeasureAll(hopeless).size(), 200u);
  EXPECT_EQ(hopeless.reason(),
            "target error is below what the model can reach; nothing more to gain");
}

TEST(ProcessPlanner, MeasuresNearPosesTogetherWhereTravelCosts) {
  const auto way = [](const DirectionPair& from, const DirectionPair& to) {
    return AngleBetween(from.wi, to.wi) + AngleBetween(from.wo, to.wo);
  };
  const auto length = [&](const SessionCosts& costs) {
    ProcessPlanner planner(Candidates(), Options(60), costs);
    const std::vector<Proposal> proposals = MeasureAll(planner);
    double sum = 0;
    for (std::size_t n = 1; n < proposals.size(); ++n) {
      sum += way(proposals[n - 1].directions, proposals[n].directions);
    }
    return sum;
  };
  const SessionCosts costs{.travel = way,
                           .pose = [](const DirectionPair&, const Rgb&) { return 0.5; }};
  EXPECT_LT(length(costs), 0.8 * length({}));
}

TEST(ProcessPlanner, ExposesMoreThanOnceWhereNoiseRulesAndFramesAreCheap) {
  const auto frames_of_last = [](double noise, double frame_s) {
    SessionCosts costs;
    costs.pose = [](const DirectionPair&, const Rgb&) { return 3.0; };
    costs.frame = [frame_s](const DirectionPair&, const Rgb&) { return frame_s; };
    costs.max_frames = 8;
    ProcessPlannerOptions options = Options(20);
    options.gain.noise = [noise](const DirectionPair&, const Rgb& f_r) { return Rgb(noise * f_r); };
    ProcessPlanner planner(Candidates(), options, costs);
    return MeasureAll(planner).back().frames;
  };
  EXPECT_EQ(frames_of_last(0.01, 0.3), 1);
  EXPECT_EQ(frames_of_last(0.3, 0.01), 8);
  EXPECT_GT(frames_of_last(0.3, 0.3), 1);
  EXPECT_EQ(frames_of_last(0.3, 30), 1);
}

}  // namespace
}  // namespace gonio
