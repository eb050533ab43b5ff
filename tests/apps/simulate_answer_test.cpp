// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/simulate_answer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace gonio {
namespace {

SimulatedSession Session(const std::string& plan, double poses) {
  SimulatedSession session;
  session.plan = plan;
  if (poses > 0) session.by_predicted = {poses, Seconds(360 * poses)};
  if (poses > 0) session.male_at_stop = poses / 1000;
  return session;
}

TEST(SimulateAnswer, IsMedianAnd80PercentIntervalOfEachPlan) {
  std::vector<SimulatedSession> sessions;
  for (int i = 0; i <= 10; ++i) sessions.push_back(Session("a", 10 + i));
  sessions.push_back(Session("b", 7));
  const std::vector<Answer> answers = AnswersOf(sessions);
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_EQ(answers[0].plan, "a");
  EXPECT_EQ(answers[0].sessions, 11);
  const Attained& a = answers[0].by_predicted;
  EXPECT_EQ(a.sessions, 11);
  EXPECT_DOUBLE_EQ(a.poses.low, 11);
  EXPECT_DOUBLE_EQ(a.poses.median, 15);
  EXPECT_DOUBLE_EQ(a.poses.high, 19);
  EXPECT_DOUBLE_EQ(a.hours.median, 1.5);
  EXPECT_DOUBLE_EQ(answers[0].male_at_stop.median, 0.015);
  EXPECT_EQ(answers[0].by_true.sessions, 0);
  EXPECT_TRUE(std::isinf(answers[0].by_true.poses.low));
  EXPECT_DOUBLE_EQ(answers[1].by_predicted.poses.median, 7);
}

TEST(SimulateAnswer, CountsASessionThatNeverGotThereAsInfinitelyLong) {
  const auto answer =
      AnswersOf({Session("a", 10), Session("a", 12), Session("a", 0), Session("a", 11)}).front();
  EXPECT_EQ(answer.by_predicted.sessions, 3);
  EXPECT_DOUBLE_EQ(answer.by_predicted.poses.median, 11.5);
  EXPECT_TRUE(std::isinf(answer.by_predicted.poses.high));
  EXPECT_EQ(ToText(answer.by_predicted.poses, 1), "11.5 (10.3 to never)");
  EXPECT_DOUBLE_EQ(answer.male_at_stop.median, 0.011);  // of those that stop
}

TEST(SimulateAnswer, SaysNeverAndNothing) {
  const double never = std::numeric_limits<double>::infinity();
  EXPECT_EQ(ToText({never, never, never}, 0), "never");
  EXPECT_EQ(ToText(SpreadOf({}), 0), "-");
}

}  // namespace
}  // namespace gonio
