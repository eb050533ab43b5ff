// SPDX-License-Identifier: Apache-2.0
#include "planner/sequence_planner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "core/units.h"

namespace gonio {
namespace {

const CandidateOptions kRaster{.phi = PhiChoice::kAcross};

std::vector<Candidate> Raster(int rows, int columns) {
  return MakeCandidates(
      {.theta_h_count = rows, .theta_d_count = columns, .phi = PhiChoice::kAcross}, {});
}

TEST(RasterOrder, VisitsTheDenseRasterRowByRowToAndFro) {
  const std::vector<int> order = RasterOrder(MakeCandidates(kRaster, {}), kRaster, {});
  ASSERT_EQ(order.size(), 8100u);
  for (int n = 0; n < 8100; ++n) {
    const int row = n / 90;
    const int column = row % 2 == 0 ? n % 90 : 89 - n % 90;
    EXPECT_EQ(order[n], row * 90 + column);
  }
}

TEST(RasterOrder, KeepsEveryKthRowAndColumn) {
  const std::vector<Candidate> candidates = MakeCandidates(kRaster, {});
  EXPECT_EQ(RasterOrder(candidates, kRaster, {.every_theta_h = 3}).size(), 30u * 90);
  EXPECT_EQ(RasterOrder(candidates, kRaster, {.every_theta_h = 11}).size(), 9u * 90);
  const std::vector<int> both =
      RasterOrder(candidates, kRaster, {.every_theta_h = 4, .every_theta_d = 10});
  EXPECT_EQ(both.size(), 23u * 9);
  for (const int i : both) {
    EXPECT_EQ(candidates[i].row % 4, 0);
    EXPECT_EQ(candidates[i].column % 10, 0);
  }
}

TEST(RasterOrder, CountsRowsOfTheRasterNotOfWhatIsReachable) {
  const std::vector<Candidate> candidates = MakeCandidates(
      kRaster, [](const DirectionPair& pair) { return ToHalfDiff(pair).theta_h > 0.1; });
  for (const int i : RasterOrder(candidates, kRaster, {.every_theta_h = 5})) {
    EXPECT_EQ(candidates[i].row % 5, 0);
  }
}

TEST(RasterOrder, NeverExceedsItsBudgetAndUsesMostOfIt) {
  const std::vector<Candidate> candidates = MakeCandidates(kRaster, {});
  for (int budget = 1; budget < 600; budget += budget < 30 ? 1 : 37) {
    const std::vector<int> order = RasterOrder(candidates, kRaster, {.max_poses = budget});
    EXPECT_LE(static_cast<int>(order.size()), budget);
    EXPECT_GE(static_cast<int>(order.size()), 2 * budget / 3) << budget;
    EXPECT_EQ(std::set<int>(order.begin(), order.end()).size(), order.size());
  }
}

TEST(RasterOrder, SpansTheWholeRangeWithinItsBudget) {
  const std::vector<Candidate> candidates = MakeCandidates(kRaster, {});
  const std::vector<int> order = RasterOrder(candidates, kRaster, {.max_poses = 100});
  ASSERT_EQ(order.size(), 100u);
  std::set<int> rows;
  std::set<int> columns;
  for (const int i : order) {
    rows.insert(candidates[i].row);
    columns.insert(candidates[i].column);
  }
  EXPECT_EQ(rows.size(), 10u);
  EXPECT_EQ(columns.size(), 10u);
  EXPECT_LE(*rows.begin(), 5);
  EXPECT_GE(*rows.rbegin(), 84);
  EXPECT_LE(*columns.begin(), 5);
  EXPECT_GE(*columns.rbegin(), 84);
}

TEST(RasterOrder, IgnoresABudgetThatIsLargeEnough) {
  const std::vector<Candidate> candidates = Raster(5, 6);
  EXPECT_EQ(RasterOrder(candidates, kRaster, {.max_poses = 30}).size(), 30u);
  EXPECT_EQ(RasterOrder(candidates, kRaster, {.max_poses = 1000}).size(), 30u);
}

TEST(RasterOrder, StaysWithinItsBudgetWhereTheRigReachesLittle) {
  const std::vector<Candidate> candidates = MakeCandidates(
      kRaster, [](const DirectionPair& pair) { return ToHalfDiff(pair).theta_d < 0.3; });
  const std::vector<int> order = RasterOrder(candidates, kRaster, {.max_poses = 50});
  EXPECT_FALSE(order.empty());
  EXPECT_LE(order.size(), 50u);
  EXPECT_EQ(std::set<int>(order.begin(), order.end()).size(), order.size());
}

TEST(RandomOrder, IsTheSameForTheSameSeedOnly) {
  EXPECT_EQ(RandomOrder(1000, 100, 7), RandomOrder(1000, 100, 7));
  EXPECT_NE(RandomOrder(1000, 100, 7), RandomOrder(1000, 100, 8));
}

TEST(RandomOrder, StaysTheSameOnEveryMachine) {
  // mt19937_64 is exact in the standard, and the shuffle is our own.
  EXPECT_EQ(RandomOrder(10, 0, 1), RandomOrder(10, 10, 1));
  const std::vector<int> five = RandomOrder(8100, 5, 1);
  EXPECT_EQ(five, (std::vector<int>{3053, 6516, 8088, 482, 796}));
}

TEST(RandomOrder, DrawsDifferentCandidates) {
  const std::vector<int> order = RandomOrder(500, 200, 3);
  EXPECT_EQ(order.size(), 200u);
  EXPECT_EQ(std::set<int>(order.begin(), order.end()).size(), 200u);
  EXPECT_GE(*std::min_element(order.begin(), order.end()), 0);
  EXPECT_LT(*std::max_element(order.begin(), order.end()), 500);
}

TEST(RandomOrder, ShufflesAllIfFewerAreLeftThanAskedFor) {
  for (const int count : {0, 20, 1000}) {
    std::vector<int> order = RandomOrder(20, count, 5);
    EXPECT_FALSE(std::is_sorted(order.begin(), order.end()));
    std::sort(order.begin(), order.end());
    std::vector<int> all(20);
    std::iota(all.begin(), all.end(), 0);
    EXPECT_EQ(order, all);
  }
  EXPECT_TRUE(RandomOrder(0, 10, 1).empty());
}

TEST(RandomOrder, DrawsEveryCandidateAboutEquallyOften) {
  constexpr int kSeeds = 4000;
  int drawn[20] = {};
  int first[20] = {};
  for (int seed = 0; seed < kSeeds; ++seed) {
    const std::vector<int> order = RandomOrder(20, 5, seed);
    for (const int i : order) ++drawn[i];
    ++first[order[0]];
  }
  // Five standard deviations of a binomial.
  for (const int count : drawn) EXPECT_NEAR(count, 0.25 * kSeeds, 5 * 27.4);
  for (const int count : first) EXPECT_NEAR(count, 0.05 * kSeeds, 5 * 13.8);
}

TEST(SequencePlanner, ProposesItsOrderWithItsLabel) {
  const std::vector<Candidate> candidates = Raster(3, 3);
  SequencePlanner planner(candidates, {4, 0, 8}, "raster");
  EXPECT_EQ(planner.MaxPoses(), 3);
  EXPECT_FALSE(planner.PredictedError().has_value());
  EXPECT_FALSE(planner.Predict(candidates[0].directions).has_value());
  for (const int expected : {4, 0, 8}) {
    const auto proposal = planner.Next();
    ASSERT_TRUE(proposal.has_value());
    EXPECT_EQ(proposal->candidate, expected);
    EXPECT_EQ(proposal->reason, "raster");
    EXPECT_EQ(proposal->directions.wi, candidates[expected].directions.wi);
    if (expected == 0) {
      planner.Reject(*proposal);
    } else {
      planner.Observe(*proposal, {});
    }
  }
  EXPECT_FALSE(planner.Next().has_value());
  EXPECT_EQ(planner.reason(), "every planned pose was visited");
}

TEST(SequencePlannerDeathTest, AbortsOnAnAnswerOfNoCandidate) {
  SequencePlanner planner(Raster(3, 3), {4, 0}, "raster");
  for (const int candidate : {-1, 9}) {
    EXPECT_DEATH(
        planner.Reject({.directions = {}, .candidate = candidate, .score = 0, .reason = ""}),
        "answers name a candidate of the raster");
  }
}

}  // namespace
}  // namespace gonio
