// SPDX-License-Identifier: Apache-2.0
#include "planner/information_planner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "brdf/analytic.h"
#include "core/units.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

const AnalyticBrdf& Paint() {
  static const AnalyticBrdf brdf("paint",
                                 {Lambert{{0.2, 0.3, 0.4}}, Ggx{.roughness = 0.2, .ior = 1.5}});
  return brdf;
}

std::vector<Candidate> Candidates(int rows = 20, int columns = 20) {
  return MakeCandidates({.theta_h_count = rows, .theta_d_count = columns}, {});
}

InformationOptions Options(int max_poses) {
  InformationOptions options;
  options.max_poses = max_poses;
  options.prior = GenericPrior({.lobes = 2, .knots = 5});
  return options;
}

// Measures until the planner has enough; returns its proposals.
std::vector<Proposal> MeasureAll(Planner& planner, double noise = 0.01) {
  Random random(1, 0);
  std::vector<Proposal> proposals;
  while (const auto next = planner.Next()) {
    proposals.push_back(*next);
    planner.Observe(*next, ReadingAt(Paint(), next->directions, noise, random));
  }
  return proposals;
}

TEST(InformationPlanner, OpensWithFixedPosesAndThenGoesByInformation) {
  InformationPlanner planner(Candidates(), Options(20));
  EXPECT_EQ(planner.MaxPoses(), 20);
  EXPECT_EQ(planner.fit(), nullptr);
  const std::vector<Proposal> proposals = MeasureAll(planner);
  ASSERT_EQ(proposals.size(), 20u);
  std::size_t opening = 0;
  while (opening < proposals.size() && proposals[opening].reason == "opening") ++opening;
  EXPECT_GE(opening, 4u);
  EXPECT_LE(opening, 12u);
  for (std::size_t n = opening; n < proposals.size(); ++n) {
    EXPECT_EQ(proposals[n].reason, "information");
    EXPECT_GT(proposals[n].score, 0);
    EXPECT_LE(proposals[n].score, 1);
  }
}

TEST(InformationPlanner, EndsWithTheBudgetAndKnowsItsErrorThen) {
  InformationPlanner planner(Candidates(), Options(15));
  EXPECT_EQ(MeasureAll(planner).size(), 15u);
  EXPECT_EQ(planner.reason(), "pose budget reached");
  ASSERT_TRUE(planner.PredictedError().has_value());
  EXPECT_GT(*planner.PredictedError(), 0);
  ASSERT_NE(planner.fit(), nullptr);
  EXPECT_EQ(planner.fit()->summary().samples, 15);
}

TEST(InformationPlanner, TakesABudgetSmallerThanItsOpening) {
  for (const int budget : {1, 3}) {
    InformationPlanner planner(Candidates(), Options(budget));
    const std::vector<Proposal> proposals = MeasureAll(planner);
    EXPECT_EQ(static_cast<int>(proposals.size()), budget);
    EXPECT_EQ(planner.reason(), "pose budget reached");
    EXPECT_TRUE(planner.PredictedError().has_value());
  }
}

TEST(InformationPlanner, EndsAtTheTargetError) {
  InformationOptions options = Options(100);
  options.target_error = 0.02;
  InformationPlanner planner(Candidates(), options);
  const std::vector<Proposal> proposals = MeasureAll(planner);
  EXPECT_LT(proposals.size(), 100u);
  EXPECT_EQ(planner.reason(), "target error reached");
  EXPECT_LE(*planner.PredictedError(), 0.02);
}

TEST(InformationPlanner, EndsWhenNoPoseWouldTeachEnough) {
  InformationOptions options = Options(100);
  options.min_gain = 0.05;
  InformationPlanner planner(Candidates(), options);
  const std::vector<Proposal> proposals = MeasureAll(planner);
  EXPECT_LT(proposals.size(), 100u);
  EXPECT_EQ(planner.reason(), "no more gain");
  for (const Proposal& proposal : proposals) {
    EXPECT_TRUE(proposal.reason == "opening" || proposal.score >= 0.05);
  }
}

TEST(InformationPlanner, EndsWhenEveryCandidateWasMeasured) {
  InformationOptions options = Options(100);
  options.min_gain = 0;
  InformationPlanner planner(Candidates(4, 4), options);
  EXPECT_EQ(MeasureAll(planner).size(), 16u);
  EXPECT_EQ(planner.reason(), "no candidate left");
}

TEST(InformationPlanner, EndsWhereNoReachableDirectionCounts) {
  InformationOptions options = Options(100);
  options.gain.max_polar = RadFromDeg(30);
  const std::vector<Candidate> candidates = MakeCandidates(
      {.theta_h_count = 10, .theta_d_count = 10},
      [](const DirectionPair& pair) { return ToHalfDiff(pair).theta_d > RadFromDeg(50); });
  InformationPlanner planner(candidates, options);
  EXPECT_LT(MeasureAll(planner).size(), 12u);
  EXPECT_EQ(planner.reason(), "no more gain");
}

TEST(InformationPlanner, EndsWhenEveryPoseIsRejected) {
  InformationPlanner planner(Candidates(5, 5), Options(100));
  std::set<int> rejected;
  while (const auto next = planner.Next()) {
    EXPECT_TRUE(rejected.insert(next->candidate).second);
    planner.Reject(*next);
  }
  EXPECT_EQ(rejected.size(), 25u);
  EXPECT_EQ(planner.reason(), "no pose could be measured");
  EXPECT_FALSE(planner.PredictedError().has_value());
}

TEST(InformationPlanner, EndsWithTheBudgetWhenNoReadingIsUsable) {
  InformationPlanner planner(Candidates(), Options(12));
  const BrdfSample unusable{.directions = {},
                            .f_r = Rgb::Zero(),
                            .sigma = Rgb::Constant(std::numeric_limits<double>::infinity())};
  int poses = 0;
  while (const auto next = planner.Next()) {
    planner.Observe(*next, {next->directions, unusable.f_r, unusable.sigma});
    ++poses;
  }
  EXPECT_EQ(poses, 12);
  EXPECT_FALSE(planner.reason().empty());
}

TEST(InformationPlanner, DoesNotCountRejectedPosesAgainstItsBudget) {
  InformationPlanner planner(Candidates(), Options(12));
  Random random(1, 0);
  int measured = 0;
  for (int n = 0; const auto next = planner.Next(); ++n) {
    if (n % 3 == 0) {
      planner.Reject(*next);
    } else {
      planner.Observe(*next, ReadingAt(Paint(), next->directions, 0.01, random));
      ++measured;
    }
  }
  EXPECT_EQ(measured, 12);
}

TEST(InformationPlanner, NeverMeasuresAPoseTwice) {
  InformationPlanner planner(Candidates(8, 8), Options(50));
  std::set<int> seen;
  for (const Proposal& proposal : MeasureAll(planner)) {
    EXPECT_TRUE(seen.insert(proposal.candidate).second);
  }
}

TEST(InformationPlanner, OpensOnlyWithWhatIsReachable) {
  const auto reachable = [](const DirectionPair& pair) {
    return AngleBetween(pair.wi, pair.wo) > RadFromDeg(40) && pair.cos_theta_i() > 0.4;
  };
  InformationPlanner planner(MakeCandidates({}, reachable), Options(12));
  for (const Proposal& proposal : MeasureAll(planner)) EXPECT_TRUE(reachable(proposal.directions));
}

TEST(InformationPlanner, OpensWithOnePoseIfOnlyOneIsReachable) {
  std::vector<Candidate> one = Candidates();
  one.resize(1);
  InformationPlanner planner(one, Options(12));
  EXPECT_EQ(MeasureAll(planner).size(), 1u);
  EXPECT_FALSE(planner.reason().empty());
}

TEST(InformationPlanner, PredictsOnceItHasAFit) {
  InformationPlanner planner(Candidates(), Options(20));
  const DirectionPair pair = ToDirections({0.4, 0.5, 1});
  EXPECT_FALSE(planner.Predict(pair).has_value());
  EXPECT_FALSE(planner.PredictedError().has_value());
  MeasureAll(planner);
  const Rgb predicted = *planner.Predict(pair);
  EXPECT_LT((predicted / *Paint().Eval(pair)).log().abs().maxCoeff(), 0.3);
}

TEST(InformationPlanner, LowersItsPredictedError) {
  InformationPlanner planner(Candidates(), Options(60));
  Random random(1, 0);
  std::vector<double> errors;
  while (const auto next = planner.Next()) {
    if (planner.PredictedError()) errors.push_back(*planner.PredictedError());
    planner.Observe(*next, ReadingAt(Paint(), next->directions, 0.01, random));
  }
  ASSERT_GT(errors.size(), 30u);
  EXPECT_LT(errors.back(), 0.7 * errors.front());
}

TEST(InformationPlannerDeathTest, AbortsWithoutCandidates) {
  EXPECT_DEATH(InformationPlanner({}, Options(3)), "a planner needs candidates");
}

}  // namespace
}  // namespace gonio
