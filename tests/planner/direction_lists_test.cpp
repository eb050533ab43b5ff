// SPDX-License-Identifier: Apache-2.0
#include "planner/direction_lists.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>

#include "planner/sequence_planner.h"
#include "tests/fitting/training_set.h"

namespace gonio {
namespace {

class DirectionListsTest : public testing::Test {
 protected:
  static CandidateOptions Raster() { return {.theta_h_count = 30, .theta_d_count = 20}; }
  const TrainingSet training_;
  const PcaBasis basis_{training_.materials(), AngleGrid(20, 12, 6)};
  const std::vector<Candidate> candidates_ = MakeCandidates(Raster(), {});

  void ExpectDifferentAndFarFromTheHorizon(const std::vector<int>& order) {
    EXPECT_EQ(std::set<int>(order.begin(), order.end()).size(), order.size());
    for (const int i : order) {
      EXPECT_GE(candidates_[i].directions.cos_theta_i(), std::cos(kListMaxPolar));
      EXPECT_GE(candidates_[i].directions.cos_theta_o(), std::cos(kListMaxPolar));
    }
  }

  // What a basis predicts of a direction's m, given noisy readings at others, leaves this variance
  // at worst.
  double WorstVariance(const std::vector<int>& order) {
    Eigen::MatrixXd rows(basis_.rank(), static_cast<Eigen::Index>(order.size()));
    for (std::size_t i = 0; i < order.size(); ++i) {
      rows.col(static_cast<Eigen::Index>(i)) = basis_.Row(candidates_[order[i]].angles);
    }
    Eigen::MatrixXd information = rows * rows.transpose() / 0.005;
    information.diagonal().array() += 1;
    const Eigen::MatrixXd covariance = information.inverse();
    double worst = 0;
    for (const Candidate& candidate : candidates_) {
      if (candidate.directions.cos_theta_i() < std::cos(kListMaxPolar)) continue;
      if (candidate.directions.cos_theta_o() < std::cos(kListMaxPolar)) continue;
      const Eigen::VectorXd row = basis_.Row(candidate.angles);
      worst = std::max(worst, row.dot(covariance * row));
    }
    return worst;
  }
};

TEST_F(DirectionListsTest, NielsenTakesTheCandidatesNearestToThePublishedFive) {
  const auto fine = MakeCandidates({.theta_h_count = 90, .theta_d_count = 90}, {});
  const std::vector<int> order = NielsenOrder(fine);
  ASSERT_EQ(order.size(), 5);
  const double published[5][2] = {{1.4, 4.0}, {76.7, 13.1}, {7.6, 78.9}, {2.5, 73.8}, {12.9, 51.6}};
  for (int n = 0; n < 5; ++n) {
    const HalfDiff& angles = fine[order[n]].angles;
    EXPECT_NEAR(std::sqrt(DegFromRad(angles.theta_h)), std::sqrt(published[n][0]), 0.4) << n;
    EXPECT_NEAR(DegFromRad(angles.theta_d), published[n][1], 6) << n;
  }
}

TEST_F(DirectionListsTest, ShorterPivotedOrdersBeginLongerOnes) {
  const std::vector<int> few = PivotedOrder(candidates_, basis_, 7);
  const std::vector<int> many = PivotedOrder(candidates_, basis_, 100);
  ASSERT_EQ(few.size(), 7);
  ASSERT_EQ(many.size(), 100);
  EXPECT_TRUE(std::equal(few.begin(), few.end(), many.begin()));
  ExpectDifferentAndFarFromTheHorizon(many);
}

TEST_F(DirectionListsTest, PivotedStartsWhereTheTrainingMaterialsDifferMost) {
  const int first = PivotedOrder(candidates_, basis_, 1).front();
  const double most = basis_.Row(candidates_[first].angles).squaredNorm();
  for (const int other : RandomOrder(candidates_.size(), 50, 1)) {
    if (candidates_[other].directions.cos_theta_i() < std::cos(kListMaxPolar)) continue;
    if (candidates_[other].directions.cos_theta_o() < std::cos(kListMaxPolar)) continue;
    EXPECT_LE(basis_.Row(candidates_[other].angles).squaredNorm(), most);
  }
}

TEST_F(DirectionListsTest, FrostOrdersAreOfAnyLength) {
  for (const int count : {1, 6, basis_.rank() + 40, 100000}) {
    const std::vector<int> order = FrostOrder(candidates_, basis_, count);
    EXPECT_LE(static_cast<int>(order.size()), count);
    EXPECT_GE(order.size(), static_cast<std::size_t>(std::min(count, 200)));
    ExpectDifferentAndFarFromTheHorizon(order);
  }
}

TEST_F(DirectionListsTest, BothLeaveLessUnknownThanRandomDirections) {
  constexpr int kCount = 6;
  const double pivoted = WorstVariance(PivotedOrder(candidates_, basis_, kCount));
  const double frost = WorstVariance(FrostOrder(candidates_, basis_, kCount));
  double random = 0;
  for (int seed = 0; seed < 5; ++seed) {
    random += WorstVariance(RandomOrder(candidates_.size(), kCount, seed)) / 5;
  }
  EXPECT_LT(pivoted, 0.5 * random);
  EXPECT_LT(frost, 0.7 * random);
}

TEST_F(DirectionListsTest, TakesWhatThereIsIfAllIsNearTheHorizon) {
  std::vector<Candidate> low;
  for (const Candidate& candidate : candidates_) {
    if (candidate.directions.cos_theta_i() < 0.1) low.push_back(candidate);
  }
  EXPECT_EQ(PivotedOrder(low, basis_, 3).size(), 3);
  EXPECT_EQ(FrostOrder(low, basis_, 3).size(), 3);
  EXPECT_FALSE(NielsenOrder(low).empty());
}

}  // namespace
}  // namespace gonio
