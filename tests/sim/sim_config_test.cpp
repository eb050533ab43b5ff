// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_config.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/units.h"

namespace gonio {
namespace {

constexpr const char* kBelieved = R"(
radiometry:
  responsivity: [1, 2, 3]
  electrons_per_count: 4
  read_noise_e: 5
  dark_current_e_s: 6
  multiplicative_noise: 0.07
  monitor_noise: 0.08
)";

SimConfig Read(const std::string& simulation) {
  return ReadSim(ConfigNode::Parse(kBelieved + simulation, "rig.yaml"));
}

TEST(ReadSim, TakesWhatIsLeftOutFromTheBelief) {
  const SimConfig sim = Read("simulation: {black_level_counts: 9}\n");
  EXPECT_EQ(sim.responsivity[2], 3);
  EXPECT_EQ(sim.electrons_per_count, 4);
  EXPECT_EQ(sim.read_noise, 5);
  EXPECT_EQ(sim.dark_current, 6);
  EXPECT_EQ(sim.multiplicative_noise, 0.07);
  EXPECT_EQ(sim.monitor_noise, 0.08);
  EXPECT_EQ(sim.black_level, 9);
  EXPECT_TRUE(sim.shot_noise);
  EXPECT_EQ(sim.repeatability, 0);
  EXPECT_EQ(sim.full_well, 0);
  EXPECT_EQ(Read("simulation: {full_well_e: 20000}\n").full_well, 20000);
}

TEST(ReadSim, LetsTheTruthDifferFromTheBelief) {
  const SimConfig sim = Read(
      "simulation: {responsivity: [7, 7, 7], read_noise_e: 0, shot_noise: false, "
      "encoder_resolution_deg: 0.1}\n");
  EXPECT_EQ(sim.responsivity[0], 7);
  EXPECT_EQ(sim.read_noise, 0);
  EXPECT_FALSE(sim.shot_noise);
  EXPECT_DOUBLE_EQ(sim.encoder_resolution, RadFromDeg(0.1));
}

TEST(ReadSim, RefusesAFileWithoutSimulation) {
  try {
    Read("");
    FAIL() << "no complaint";
  } catch (const ConfigError& e) {
    EXPECT_STREQ(e.what(), "rig.yaml:2: simulation: is missing");
  }
}

}  // namespace
}  // namespace gonio
