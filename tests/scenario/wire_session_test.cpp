// SPDX-License-Identifier: Apache-2.0
// The same session on a rig whose arms are controllers at the ends of serial lines, through the
// real drivers and the real serial library, in simulated time.
#include <gmock/gmock.h>

#include <sstream>

#include "tests/core/temp_dir.h"
#include "tests/scenario/wired_bench.h"

namespace gonio {
namespace {

using testing::HasSubstr;

TEST(WireSession, MeasuresWhatTheSampleIs) {
  WiredBench bench;
  const SessionSummary summary = bench.Measure(FourPoses());
  EXPECT_EQ(summary.outcome, SessionOutcome::kComplete) << summary.reason;
  ASSERT_EQ(summary.poses.size(), 4u);
  for (const auto& pose : summary.poses) {
    EXPECT_TRUE(pose.samples.front().f_r.isApprox(Rgb(0.2, 0.4, 0.6) / kPi, 0.01))
        << pose.samples.front().f_r;
  }
}

// Example failure is an encoder that is read in the wrong sense: the arms say that they are right.
TEST(WireSession, ArmsAreWhereTheySay) {
  WiredBench bench;
  ASSERT_EQ(bench.Measure(FourPoses()).poses.size(), 4u);
  for (int i = 0; i < kAxes; ++i) {
    EXPECT_NEAR(bench.doubles().Angle(i), bench.devices.axes[i]->State()->position, 1e-4)
        << kAxisNames[i];
  }
}

// The same poses on the rig without wires, noise and all.
TEST(WireSession, AgreesWithTheRigInsideTheProgramWithinItsNoise) {
  WiredBench wired(WiredBench::Noisy());
  const SessionSummary over_wires = wired.Measure(FourPoses());
  Bench inside;
  ScriptedPlanner planner(FourPoses());
  const SessionSummary without = inside.Run(planner);
  ASSERT_EQ(over_wires.poses.size(), without.poses.size());
  for (std::size_t i = 0; i < without.poses.size(); ++i) {
    const BrdfSample& a = over_wires.poses[i].samples.front();
    const BrdfSample& b = without.poses[i].samples.front();
    EXPECT_LT(((a.f_r - b.f_r) / (a.sigma.square() + b.sigma.square()).sqrt()).abs().maxCoeff(), 4);
  }
}

// Every message that the log file shows, and no other, is in the counts.
TEST(WireSession, AccountsForEveryExchange) {
  WiredBench bench;
  const TempDir dir;
  const auto file = dir.path() / "wire.log";
  bench.wires->WriteTo(file);
  ASSERT_EQ(bench.Measure(FourPoses()).poses.size(), 4u);
  std::map<std::string, long> sent;
  std::istringstream lines(ReadTextFile(file));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string time, link, way;
    words >> time >> link >> way;
    if (way == ">") ++sent[link];
  }
  EXPECT_EQ(sent.size(), 3u);
  for (const auto& [link, count] : bench.wires->Counts()) {
    EXPECT_EQ(count.sent, sent[link]) << link;
    EXPECT_EQ(count.failures, 0) << link;
    EXPECT_GT(count.bytes_received, 0) << link;
  }
}

TEST(WireSession, ACableThatIsPulledOutEndsIt) {
  WiredBench bench;
  ScriptedPlanner planner(FourPoses());
  planner.on_observe = [&](int samples) {
    if (samples == 2) bench.line("first").HangUp();
  };
  const SessionSummary summary = bench.Measure(planner);
  EXPECT_EQ(summary.outcome, SessionOutcome::kDeviceFault);
  EXPECT_EQ(summary.poses.size(), 2u);
  EXPECT_THAT(summary.reason, HasSubstr("disconnected"));
}

}  // namespace
}  // namespace gonio
