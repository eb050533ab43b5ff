// SPDX-License-Identifier: Apache-2.0
// The promises of planner/planner.h, asked of any planner. Include in one .cpp per test program and
// instantiate:
//
//   INSTANTIATE_TEST_SUITE_P(Grid, PlannerConformance, testing::Values(MakeGridSubject));

#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <set>
#include <vector>

#include "planner/candidates.h"
#include "planner/planner.h"

namespace gonio {

// A planner that was just made, and the set it may choose from.
struct PlannerSubject {
  std::unique_ptr<Planner> planner;
  std::vector<Candidate> candidates;
};
using PlannerFactory = std::function<PlannerSubject()>;

class PlannerConformance : public testing::TestWithParam<PlannerFactory> {
 protected:
  void SetUp() override { subject_ = GetParam()(); }

  Planner& planner() { return *subject_.planner; }
  // More answers than a planner that keeps promise 5 can ever ask for.
  int Limit() const { return static_cast<int>(subject_.candidates.size()) + 1; }

  // A material with a highlight, the same for every planner.
  static BrdfSample Measure(const DirectionPair& pair) {
    const double peak = std::exp(-50 * std::pow(ToHalfDiff(pair).theta_h, 2));
    const Rgb f_r = Rgb(0.1, 0.2, 0.3) + peak;
    return {.directions = pair, .f_r = f_r, .sigma = 0.01 * f_r};
  }

  // Answers `next`: every `reject_every`-th pose (0: none) cannot be measured.
  static void Answer(Planner& planner, const Proposal& next, int n, int reject_every) {
    if (reject_every > 0 && n % reject_every == 0) {
      planner.Reject(next);
    } else {
      planner.Observe(next, Measure(next.directions));
    }
  }

  std::vector<Proposal> Run(Planner& planner, int reject_every) const {
    std::vector<Proposal> proposals;
    for (int n = 0; n < Limit(); ++n) {
      const auto next = planner.Next();
      if (!next) return proposals;
      proposals.push_back(*next);
      Answer(planner, *next, n, reject_every);
    }
    ADD_FAILURE() << "still going after " << Limit() << " poses";
    return proposals;
  }

  PlannerSubject subject_;
};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(PlannerConformance);

// Promise 1. Example failure is a planner that computes a pose instead of choosing one, and sends
// the arms where the rig does not reach.
TEST_P(PlannerConformance, ProposesOnlyItsCandidates) {
  const std::vector<Proposal> proposals = Run(planner(), 5);
  ASSERT_FALSE(proposals.empty());
  for (const Proposal& proposal : proposals) {
    ASSERT_GE(proposal.candidate, 0);
    ASSERT_LT(proposal.candidate, static_cast<int>(subject_.candidates.size()));
    const DirectionPair& pair = subject_.candidates[proposal.candidate].directions;
    EXPECT_EQ(proposal.directions.wi, pair.wi);
    EXPECT_EQ(proposal.directions.wo, pair.wo);
    EXPECT_FALSE(proposal.reason.empty());
  }
}

// Promise 2. Example failure is a planner that draws its next random number in Next(), so that a
// session that asks twice skips a pose.
TEST_P(PlannerConformance, RepeatsItsProposalUntilItIsAnswered) {
  for (int n = 0; n < 12; ++n) {
    const auto next = planner().Next();
    if (!next) break;
    for (int again = 0; again < 3; ++again) {
      const auto same = planner().Next();
      ASSERT_TRUE(same.has_value());
      EXPECT_EQ(same->candidate, next->candidate);
      EXPECT_EQ(same->score, next->score);
      EXPECT_EQ(same->reason, next->reason);
    }
    Answer(planner(), *next, n, 4);
  }
}

// Promise 3. Example failure is a planner that forgets rejections when it refits, and asks for the
// same shadowed pose for ever.
TEST_P(PlannerConformance, NeverProposesARejectedPoseAgain) {
  std::set<int> rejected;
  for (int n = 0; n < Limit(); ++n) {
    const auto next = planner().Next();
    if (!next) break;
    EXPECT_FALSE(rejected.contains(next->candidate)) << next->candidate;
    if (n % 2 == 0) rejected.insert(next->candidate);
    Answer(planner(), *next, n, 2);
  }
  EXPECT_FALSE(rejected.empty());
}

// Promise 4. Example failure is a planner that iterates over an unordered container, or is seeded
// by the time of day.
TEST_P(PlannerConformance, ProposesTheSameForTheSameObservations) {
  for (const int reject_every : {0, 3}) {
    PlannerSubject a = GetParam()();
    PlannerSubject b = GetParam()();
    const std::vector<Proposal> first = Run(*a.planner, reject_every);
    const std::vector<Proposal> second = Run(*b.planner, reject_every);
    ASSERT_EQ(first.size(), second.size());
    for (std::size_t n = 0; n < first.size(); ++n) {
      EXPECT_EQ(first[n].candidate, second[n].candidate);
      EXPECT_EQ(first[n].score, second[n].score);
    }
    EXPECT_EQ(a.planner->reason(), b.planner->reason());
  }
}

// Promise 5. Example failure is a planner that stops because it has run out of ideas and leaves the
// report without a reason, or that starts again when asked once more.
TEST_P(PlannerConformance, EndsAfterFinitelyManyStepsAndSaysWhy) {
  Run(planner(), 0);
  EXPECT_FALSE(planner().Next().has_value());
  const std::string reason = planner().reason();
  EXPECT_FALSE(reason.empty());
  EXPECT_FALSE(planner().Next().has_value());
  EXPECT_EQ(planner().reason(), reason);
}

// Promise 6. Example failure is a planner that crosses off its last proposal, whatever was
// measured.
TEST_P(PlannerConformance, LearnsOfPosesItDidNotAskFor) {
  const int last = static_cast<int>(subject_.candidates.size()) - 1;
  std::set<int> told;
  for (const int candidate : {last, last / 2}) {
    const auto next = planner().Next();
    ASSERT_TRUE(next.has_value());
    const DirectionPair& pair = subject_.candidates[candidate].directions;
    const Proposal other{.directions = pair, .candidate = candidate, .reason = "resumed"};
    Answer(planner(), other, candidate == last ? 0 : 1, 2);
    told.insert(candidate);
  }
  for (const Proposal& proposal : Run(planner(), 0)) {
    EXPECT_FALSE(told.contains(proposal.candidate)) << proposal.candidate;
  }
}

// Promise 5, MaxPoses(). Example failure is a planner that lets a rig on which every pose is
// refused run all night.
TEST_P(PlannerConformance, EndsWhenNothingCanBeMeasured) {
  const std::vector<Proposal> proposals = Run(planner(), 1);
  EXPECT_FALSE(proposals.empty());
  EXPECT_FALSE(planner().Next().has_value());
  EXPECT_FALSE(planner().reason().empty());
}

// MaxPoses(). Example failure is a budget that rejected poses, or the opening, do not count in.
TEST_P(PlannerConformance, MeasuresAtMostMaxPoses) {
  for (const int reject_every : {0, 2}) {
    PlannerSubject subject = GetParam()();
    const int most = subject.planner->MaxPoses();
    const std::size_t answers = Run(*subject.planner, reject_every).size();
    const std::size_t rejected = reject_every == 0 ? 0 : (answers + 1) / 2;
    EXPECT_LE(static_cast<int>(answers - rejected), most);
    EXPECT_EQ(subject.planner->MaxPoses(), most);
  }
}

}  // namespace gonio
