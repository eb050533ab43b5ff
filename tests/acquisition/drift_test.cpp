// SPDX-License-Identifier: Apache-2.0
#include "acquisition/drift.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "sim/random.h"

namespace gonio {
namespace {

constexpr Seconds Hours(double hours) { return Seconds(3600 * hours); }

ReferenceVisit VisitAt(double hours, double signal, double sigma) {
  return {Hours(hours), Rgb::Constant(signal), Rgb::Constant(sigma)};
}

TEST(DriftTracker, KnowsNothingWithoutVisits) {
  const DriftTracker tracker(0.01);
  EXPECT_TRUE((tracker.At(Hours(3)).value == 1).all());
  EXPECT_TRUE((tracker.At(Hours(3)).sigma == 0).all());
}

TEST(DriftTracker, IsStraightBetweenVisitsAndLevelAfterThem) {
  DriftTracker tracker(0.01);
  tracker.Add(VisitAt(1, 0.4, 1e-9));
  tracker.Add(VisitAt(2, 0.42, 1e-9));
  tracker.Add(VisitAt(4, 0.38, 1e-9));
  const auto at = [&](double hours) { return tracker.At(Hours(hours)).value[1]; };
  EXPECT_NEAR(at(0.5), 1, 1e-6);
  EXPECT_NEAR(at(1), 1, 1e-6);
  EXPECT_NEAR(at(1.5), 1.025, 1e-6);
  EXPECT_NEAR(at(2), 1.05, 1e-6);
  EXPECT_NEAR(at(3), 1, 1e-6);
  EXPECT_NEAR(at(9), 0.95, 1e-6);
}

// Example failure: an uncertainty that is that of the nearest visit, wherever it is.
TEST(DriftTracker, IsLeastSureFarFromVisits) {
  DriftTracker tracker(0.01);
  for (const double hours : {0.0, 1.0, 2.0}) tracker.Add(VisitAt(hours, 1, 1e-6));
  const auto sigma = [&](double hours) { return tracker.At(Hours(hours)).sigma[0]; };
  EXPECT_LT(sigma(1), 1e-5);
  const double q = tracker.diffusion_per_hour();
  EXPECT_NEAR(sigma(1.5), std::sqrt(q * 0.25), 1e-5);
  EXPECT_NEAR(sigma(1.1), std::sqrt(q * 0.09), 1e-5);
  EXPECT_NEAR(sigma(2.5), std::sqrt(q * 0.5), 1e-5);
}

// Visits that scatter by no more than their noise are averaged. Example failure: a correction by
// the last visit alone, which would put its noise into every sample after it.
TEST(DriftTracker, DoesNotFollowNoise) {
  Random random(3, 1);
  DriftTracker tracker(0.001);
  for (int i = 0; i < 40; ++i) tracker.Add(VisitAt(0.1 * i, 1 + 0.01 * random.Normal(), 0.01));
  const Gain gain = tracker.At(Hours(4));
  EXPECT_LT(gain.sigma[0], 0.008);
  EXPECT_LT(std::abs(gain.value[0] - 1), 3 * gain.sigma[0]);
}

struct ZScores {
  double n = 0, sum = 0, squares = 0;
  void Add(double z) {
    n += 1;
    sum += z;
    squares += z * z;
  }
  double mean() const { return sum / n; }
  double deviation() const { return std::sqrt(squares / n); }
};

// Planted walks, read with noise: the stated uncertainty is the true one, at the last visit's side
// (online) and between visits (afterwards), and not far from it where the expected drift is three
// times off, which a dozen visits do not quite make up for.
TEST(DriftTracker, IsAsSureAsItMayBe) {
  constexpr double kNoise = 0.005;
  constexpr double kEvery = 0.25;  // hours
  for (const double expected : {0.007, 0.02, 0.06}) {
    ZScores online, between;
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
      Random random(seed, 7);
      DriftTracker tracker(expected);
      Rgb walk = Rgb::Zero();
      Rgb half = Rgb::Zero();  // of the way between the last two visits
      const auto steps = [&](double hours) {
        Rgb step;
        for (double& s : step) s = 0.02 * std::sqrt(hours) * random.Normal();
        return step;
      };
      for (int k = 0; k < 12; ++k) {
        ReferenceVisit visit = VisitAt(kEvery * k, 1, kNoise);
        for (int c = 0; c < kChannels; ++c) {
          visit.signal[c] = 0.3 * (1 + walk[c] + kNoise * random.Normal());
        }
        visit.sigma *= 0.3;
        tracker.Add(visit);
        if (k == 11) break;
        half = walk + steps(kEvery / 2);
        walk = half + steps(kEvery / 2);
        const Gain gain = tracker.At(Hours(kEvery * (k + 0.5)));
        if (k >= 4) online.Add((gain.value[0] - 1 - half[0]) / gain.sigma[0]);
      }
      const Gain gain = tracker.At(Hours(kEvery * 10.5));
      between.Add((gain.value[2] - 1 - half[2]) / gain.sigma[2]);
    }
    const double slack = expected == 0.02 ? 0.1 : 0.25;
    EXPECT_NEAR(online.mean(), 0, 0.15) << expected;
    EXPECT_NEAR(online.deviation(), 1, slack) << expected;
    EXPECT_NEAR(between.mean(), 0, 0.2) << expected;
    EXPECT_NEAR(between.deviation(), 1, slack) << expected;
  }
}

// No walk, but a slope of 4 % an hour: what the last visit cannot know is in the uncertainty.
TEST(DriftTracker, StatesItsLagBehindASlope) {
  DriftTracker tracker(0.01);
  for (int k = 0; k < 8; ++k) tracker.Add(VisitAt(0.5 * k, 1 + 0.02 * k, 0.002));
  const Gain gain = tracker.At(Hours(3.9));
  const double error = gain.value[0] - (1 + 0.04 * 3.9);
  EXPECT_LT(error, -0.01);
  EXPECT_LT(std::abs(error), 1.5 * gain.sigma[0]);
}

TEST(DriftTracker, LeavesChannelsAloneThatTheReferenceDoesNotShow) {
  DriftTracker tracker(0.01);
  for (int k = 0; k < 3; ++k) {
    ReferenceVisit visit = VisitAt(k, 1 - 0.1 * k, 0.01);
    visit.sigma[0] = std::numeric_limits<double>::infinity();
    visit.signal[1] = 0.02;
    tracker.Add(visit);
  }
  const Gain gain = tracker.At(Hours(2));
  EXPECT_EQ(gain.value[0], 1);
  EXPECT_EQ(gain.sigma[0], 0);
  EXPECT_EQ(gain.value[1], 1);
  EXPECT_NEAR(gain.value[2], 0.8, 0.02);
  EXPECT_EQ(tracker.visits(), 3);
}

DriftPolicy Read(const std::string& text) {
  const ConfigNode node = ConfigNode::Parse(text, "rig.yaml");
  const DriftPolicy policy = ReadDriftPolicy(node);
  node.RefuseUnknownKeys();
  return policy;
}

TEST(DriftPolicy, IsReadAndRefused) {
  EXPECT_FALSE(DriftPolicy{}.on());
  const DriftPolicy policy = Read(
      "{every_min: 20, pose: {theta_h_deg: 10, theta_d_deg: 30}, max_change_percent: 3, "
      "when_exceeded: stop}");
  EXPECT_EQ(policy.every, Seconds(1200));
  EXPECT_TRUE(policy.on() && policy.stop && policy.pose);
  EXPECT_NEAR(*policy.max_change, 0.03, 1e-12);
  try {
    Read("{max_change_percent: 3}");
    FAIL() << "must be refused";
  } catch (const ConfigError& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("every_poses: this or every_min is needed"));
  }
}

}  // namespace
}  // namespace gonio
