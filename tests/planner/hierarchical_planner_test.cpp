// SPDX-License-Identifier: Apache-2.0
#include "planner/hierarchical_planner.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

namespace gonio {
namespace {

std::vector<Candidate> Raster(int rows, int columns) {
  return MakeCandidates({.theta_h_count = rows, .theta_d_count = columns}, {});
}

std::vector<Proposal> Scan(HierarchicalPlanner& planner) {
  std::vector<Proposal> proposals;
  while (const auto next = planner.Next()) {
    proposals.push_back(*next);
    planner.Observe(*next, {});
  }
  return proposals;
}

TEST(HierarchicalPlanner, FinishesALevelBeforeTheNext) {
  HierarchicalPlanner planner(Raster(16, 16), {}, {});
  const std::vector<Proposal> proposals = Scan(planner);
  EXPECT_EQ(proposals.size(), 256);
  for (std::size_t n = 1; n < proposals.size(); ++n) {
    EXPECT_GE(proposals[n].reason, proposals[n - 1].reason) << n;
  }
  EXPECT_EQ(planner.reason(), "every candidate was measured");
}

TEST(HierarchicalPlanner, StartsWithASparseRasterOverEverything) {
  const auto candidates = Raster(16, 16);
  HierarchicalPlanner planner(candidates, {.max_poses = 16}, {});
  std::set<int> rows, columns;
  const std::vector<Proposal> proposals = Scan(planner);
  for (const Proposal& proposal : proposals) {
    EXPECT_EQ(proposal.reason, "level 0");
    rows.insert(candidates[proposal.candidate].row);
    columns.insert(candidates[proposal.candidate].column);
  }
  EXPECT_EQ(proposals.size(), 16);
  EXPECT_EQ(rows, (std::set<int>{2, 6, 10, 14}));
  EXPECT_EQ(columns, (std::set<int>{2, 6, 10, 14}));
}

TEST(HierarchicalPlanner, TakesThePoseThatIsReachedSoonest) {
  const auto candidates = Raster(16, 16);
  const TravelTime travel = [](const DirectionPair& from, const DirectionPair& to) {
    return 3 * AngleBetween(from.wi, to.wi) + AngleBetween(from.wo, to.wo);
  };
  HierarchicalPlanner planner(candidates, {.max_poses = 16}, travel);
  const std::vector<Proposal> proposals = Scan(planner);
  for (std::size_t n = 1; n < proposals.size(); ++n) {
    const double taken = travel(proposals[n - 1].directions, proposals[n].directions);
    EXPECT_EQ(proposals[n].score, -taken);
    for (std::size_t later = n + 1; later < proposals.size(); ++later) {
      EXPECT_LE(taken, travel(proposals[n - 1].directions, proposals[later].directions));
    }
  }
}

TEST(HierarchicalPlanner, SpreadsTheLastPosesOverALevelTheyDoNotFill) {
  const auto candidates = Raster(16, 16);
  HierarchicalPlanner planner(candidates, {.max_poses = 20}, {});
  const std::vector<Proposal> proposals = Scan(planner);
  ASSERT_EQ(proposals.size(), 20);
  int upper = 0;
  for (std::size_t n = 16; n < 20; ++n) upper += candidates[proposals[n].candidate].row < 8;
  EXPECT_EQ(upper, 2);
  EXPECT_EQ(planner.reason(), "pose budget reached");
}

TEST(HierarchicalPlanner, StaysWhereItIsWhenAPoseIsRejected) {
  const auto candidates = Raster(16, 16);
  HierarchicalPlanner planner(candidates, {}, {});
  const auto first = planner.Next();
  planner.Observe(*first, {});
  const auto refused = planner.Next();
  planner.Reject(*refused);
  const auto second = planner.Next();
  EXPECT_NE(second->candidate, refused->candidate);
  EXPECT_EQ(-second->score, std::max(AngleBetween(first->directions.wi, second->directions.wi),
                                     AngleBetween(first->directions.wo, second->directions.wo)));
}

}  // namespace
}  // namespace gonio
