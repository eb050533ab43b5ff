// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session_costs.h"

#include <gtest/gtest.h>

#include "acquisition/kinematics.h"
#include "acquisition/radiometry.h"
#include "acquisition/session.h"
#include "brdf/metrics.h"
#include "fitting/process_fit.h"
#include "planner/plan.h"
#include "tests/acquisition/simulated_rig.h"
#include "tests/fitting/small_process.h"

namespace gonio {
namespace {

// Its axes are uneven: a new incidence takes over a minute, a step of the receiver two seconds.
const char* const kUnevenRigFile = GONIO_SOURCE_DIR "/configs/rig-rt300s.yaml";

RigConfig UnevenRig() { return ReadRig(ConfigNode::Load(kUnevenRigFile), ""); }

DirectionPair At(double incidence_deg, double receiver_deg) {
  return {FromSpherical(RadFromDeg(incidence_deg), 0),
          FromSpherical(RadFromDeg(receiver_deg), kPi)};
}

TEST(CostsOn, KnowsWhichAxisIsDear) {
  const SessionCosts costs = CostsOn(UnevenRig());
  EXPECT_LT(costs.travel(At(30, 30), At(30, 40)), 2.5);
  EXPECT_GT(costs.travel(At(30, 30), At(40, 30)), 60);
  EXPECT_EQ(costs.travel(At(30, 30), At(30, 30)), 0);
  // Asked before or not.
  EXPECT_EQ(costs.travel(At(30, 30), At(40, 30)),
            CostsOn(UnevenRig()).travel(At(30, 30), At(40, 30)));
}

TEST(CostsOn, CountsSettlingExposureAndReadOut) {
  const RigConfig rig = DefaultRig();
  const SessionCosts costs = CostsOn(rig);
  const double least = (rig.motion.settle + rig.camera.readout).count();
  const double bright = costs.pose(PairAt(5, 20), Rgb::Constant(100));
  const double dark = costs.pose(PairAt(5, 20), Rgb::Constant(1e-6));
  EXPECT_GE(bright, least);
  EXPECT_LT(bright, least + 0.1);
  EXPECT_DOUBLE_EQ(dark, least + rig.exposure.soft_limit.count());
}

// What the planner is told must be what a session then gets.
TEST(NoiseOn, ForetellsTheSigmaOfAReading) {
  const RigConfig rig = DefaultRig();
  const ExpectedNoise noise = NoiseOn(rig);
  int compared = 0;
  for (const double f_r : {0.002, 0.05, 0.3, 20.0}) {
    const FlatBrdf sample(Rgb(f_r, f_r, f_r));
    SimulatedRig simulated(sample);
    PoseMeasurer measurer = simulated.Prepared();
    for (const double theta_h : {10.0, 60.0}) {
      const DirectionPair pair = PairAt(theta_h, 20);
      const auto record = measurer.Measure(pair, Rgb::Constant(f_r), {});
      ASSERT_TRUE(record.ok());
      if (record->exposures.size() > 1) continue;  // another frame is not foreseen
      ++compared;
      const Rgb foretold = noise(pair, Rgb::Constant(f_r));
      const BrdfSample reading = Reduce(*record, rig).front();
      for (int c = 0; c < kChannels; ++c) {
        EXPECT_NEAR(foretold[c], reading.sigma[c], 0.1 * reading.sigma[c]) << f_r << " " << theta_h;
      }
    }
  }
  EXPECT_GE(compared, 6);
}

struct Result {
  double minutes = 0;
  double male = 0;
};

Result Measure(const Plan& plan, const RigConfig& rig, const SimConfig& truth) {
  const AnalyticBrdf sample = PaintOf(0.22, 0.25);
  const Kinematics kinematics(rig);
  const auto planner = MakePlanner(
      plan, {.reachable = [&](const DirectionPair& pair) { return kinematics.Reachable(pair); },
             .costs = CostsOn(rig)});
  SimulatedRig simulated(sample, 1, rig, truth);
  const SessionSummary summary = RunSession(
      {simulated.rig, simulated.devices, simulated.clock, *planner, nullptr}, {}, {}, {});
  EXPECT_EQ(summary.poses.size(), plan.max_poses);
  return {(summary.duration - summary.preparation).count() / 60,
          Compare(sample, *FitProcess(summary.Samples(), plan.prior),
                  {.phi_stride = 20, .theta_d_stride = 5})
              .male};
}

// Example failure is a planner that is told of the time and chooses as if it were not.
TEST(ProcessPlanner, TakesLessTimeOnUnevenAxesAtAboutTheSameError) {
  const std::string text =
      "version: 1\nname: x\nplanner: information\nmax_poses: 48\n"
      "candidates: {theta_h_count: 24, theta_d_count: 24}\ninformation: {min_gain: 0, travel: ";
  Plan mindful = ParsePlan(text + "true}\n", "plan.yaml");
  Plan careless = ParsePlan(text + "false}\n", "plan.yaml");
  mindful.prior = careless.prior = SmallProcessPrior();
  const SimConfig truth = ReadSim(ConfigNode::Load(kUnevenRigFile));
  const Result with = Measure(mindful, UnevenRig(), truth);
  const Result without = Measure(careless, UnevenRig(), truth);
  EXPECT_LT(with.minutes, 0.8 * without.minutes);
  EXPECT_LT(with.male, 1.5 * without.male);
  RecordProperty("minutes", std::to_string(with.minutes) + " " + std::to_string(without.minutes));
  RecordProperty("male", std::to_string(with.male) + " " + std::to_string(without.male));
}

}  // namespace
}  // namespace gonio
