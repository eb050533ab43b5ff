// SPDX-License-Identifier: Apache-2.0
// Hundreds of sessions in which anything may go wrong. GONIO_CAMPAIGN_SESSIONS=1000 runs a thousand
// and prints what came of them; GONIO_CAMPAIGN_FIRST is the first one's seed,
// GONIO_CAMPAIGN_TRACE=1 prints their events.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "tests/campaign/campaign_session.h"
#include "tests/campaign/collision_watch.h"
#include "tests/scenario/bench.h"

namespace gonio {
namespace {

std::uint64_t FromEnvironment(const char* name, std::uint64_t otherwise) {
  const char* const text = std::getenv(name);
  return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
}

struct Totals {
  std::map<std::string, int> outcomes, events;
  long poses = 0, calls = 0, faults = 0, starts = 0, looks = 0;
  int resumed = 0, untouched = 0;

  void Add(const CampaignResult& result) {
    ++outcomes[ToString(result.outcome)];
    for (const auto& [kind, count] : result.events) events[kind] += count;
    poses += result.poses;
    calls += result.calls;
    faults += result.faults;
    starts += result.starts;
    looks += result.looks;
    resumed += result.resumed ? 1 : 0;
    untouched += result.faults == 0 ? 1 : 0;
  }

  void Print() const {
    for (const auto& [outcome, count] : outcomes) fmt::print("{:20} {}\n", outcome, count);
    fmt::print("{:20} {}\n{:20} {}\n", "resumed", resumed, "without a fault", untouched);
    fmt::print(
        "{} poses, {} calls of devices, {} of them failed, {} moves and homings, the arms' "
        "true places looked at {} times\n",
        poses, calls, faults, starts, looks);
    for (const auto& [kind, count] : events) fmt::print("  {:20} {}\n", kind, count);
  }
};

TEST(FaultCampaign, NothingThatMayNeverHappenDoes) {
  const std::uint64_t first = FromEnvironment("GONIO_CAMPAIGN_FIRST", 1);
  const std::uint64_t sessions = FromEnvironment("GONIO_CAMPAIGN_SESSIONS", 40);
  Totals totals;
  for (std::uint64_t seed = first; seed < first + sessions; ++seed) {
    const CampaignResult result = RunCampaignSession(seed);
    totals.Add(result);
    for (const std::string& what : result.violations)
      ADD_FAILURE() << "seed " << seed << ": " << what;
  }
  totals.Print();
  // Else nothing was tried.
  EXPECT_GT(totals.faults, static_cast<long>(sessions / 4));
  EXPECT_GT(totals.events["recovered"], 0);
  EXPECT_GT(totals.resumed, 0);
  EXPECT_GT(totals.looks, 0);
}

// The watch itself: it sees what it is there for.
TEST(CollisionWatch, SeesArmsThatTouchAndATable) {
  const RigConfig rig =
      ReadRig(ConfigNode::Load(std::string(GONIO_SOURCE_DIR) + "/configs/rig-solid-arms.yaml"), "");
  const CollisionWatch watch(rig);
  EXPECT_FALSE(watch.FindAt({0, 0.8, 2, 0.8}, 0.004));
  EXPECT_EQ(watch.FindAt({0, 0.8, 0.05, 0.8}, 0.004), "light arm and camera arm");
  EXPECT_EQ(watch.FindAt({0, -0.3, 2, 0.8}, 0.004), "light arm and what stands still");
  // The camera's bracket, 450 mm out and 60 mm towards the light: 450 sin a = 60 cos a + 45 mm.
  EXPECT_TRUE(watch.FindAt({0, 0.1, RadFromDeg(13.2), 0.1}, 0));
  EXPECT_FALSE(watch.FindAt({0, 0.1, RadFromDeg(13.5), 0.1}, 0));
}

}  // namespace
}  // namespace gonio
