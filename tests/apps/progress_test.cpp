// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/progress.h"

#include <gmock/gmock.h>

#include <algorithm>

namespace gonio {
namespace {

TEST(ForPeople, RoundsToWhatMatters) {
  EXPECT_EQ(ForPeople(Seconds(0)), "0 s");
  EXPECT_EQ(ForPeople(Seconds(59.4)), "59 s");
  EXPECT_EQ(ForPeople(Seconds(59.6)), "1 min 00 s");
  EXPECT_EQ(ForPeople(Seconds(459)), "7 min 39 s");
  EXPECT_EQ(ForPeople(Seconds(3599.6)), "1 h 00 min");
  EXPECT_EQ(ForPeople(Seconds(18870)), "5 h 15 min");
}

// ctest gives a pipe for standard output; under a terminal there is nothing to see here.
TEST(ProgressLine, WritesALineEveryTenthOfTheWayInAPipe) {
  testing::internal::CaptureStdout();
  {
    ProgressLine line("measuring", false);
    for (int pose = 1; pose <= 95; ++pose) {
      line.Show({.poses = pose, .max_poses = 100, .elapsed = Seconds(pose), .predicted_error = {}});
    }
  }
  const std::string text = testing::internal::GetCapturedStdout();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 9);
  EXPECT_THAT(text, testing::StartsWith("measuring: pose 10 of 100, 10 s on the rig\n"));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("\r")));
}

TEST(ProgressLine, SaysNothingWhenQuiet) {
  testing::internal::CaptureStdout();
  {
    ProgressLine line("measuring", true);
    line.Show({.poses = 100, .max_poses = 100, .elapsed = Seconds(1), .predicted_error = {}});
  }
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

}  // namespace
}  // namespace gonio
