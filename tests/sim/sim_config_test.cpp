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

TEST(ReadSim, ReadsLampArmsImageAndSensor) {
  const SimConfig none = Read("simulation: {}\n");
  EXPECT_EQ(none.prnu, 0);
  EXPECT_EQ(none.every_px, 16);
  EXPECT_EQ(none.temperature_c, std::nullopt);
  EXPECT_EQ(none.axis_offset, SimArms{});
  const SimConfig sim = Read(
      "simulation: {lamp_flicker: 0.01, lamp_fails_at_s: 50, axis_offset_deg: [1, -2, 0, 0.5],\n"
      "  light_offset_m: [0.001, 0, -0.002], sample_radius_m: 0.02, vignetting: 1,\n"
      "  defocus_px: 1.5, veiling_glare: 0.02, every_px: 8, sensor_seed: 7, prnu: 0.01, dsnu_e: "
      "2,\n"
      "  dark_spread: 0.1, hot_pixels: 0.001, hot_dark_current_e_s: 900, dark_doubling_c: 7,\n"
      "  reference_c: 25, temperature_c: 31, nonlinearity: 0.01}\n");
  EXPECT_EQ(sim.lamp_flicker, 0.01);
  EXPECT_EQ(sim.lamp_fails_at, 50);
  EXPECT_DOUBLE_EQ(sim.axis_offset[1], RadFromDeg(-2));
  EXPECT_EQ(sim.light_offset[2], -0.002);
  EXPECT_EQ(sim.sample_radius, 0.02);
  EXPECT_EQ(sim.vignetting, 1);
  EXPECT_EQ(sim.defocus, 1.5);
  EXPECT_EQ(sim.veiling_glare, 0.02);
  EXPECT_EQ(sim.every_px, 8);
  EXPECT_EQ(sim.sensor_seed, 7);
  EXPECT_EQ(sim.prnu, 0.01);
  EXPECT_EQ(sim.dsnu, 2);
  EXPECT_EQ(sim.dark_spread, 0.1);
  EXPECT_EQ(sim.hot_pixels, 0.001);
  EXPECT_EQ(sim.hot_dark_current, 900);
  EXPECT_EQ(sim.dark_doubling, 7);
  EXPECT_EQ(sim.reference_c, 25);
  EXPECT_EQ(sim.temperature_c, 31);
  EXPECT_EQ(sim.nonlinearity, 0.01);
}

TEST(ReadSim, RefusesSquaresThatCannotBeHalved) {
  try {
    Read("simulation: {every_px: 12}\n");
    FAIL() << "no complaint";
  } catch (const ConfigError& e) {
    EXPECT_STREQ(e.what(), "rig.yaml:9: simulation.every_px: must be a power of two");
  }
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
