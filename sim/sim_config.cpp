// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_config.h"

#include "core/units.h"

namespace gonio {
namespace {

Rgb ReadRgb(const ConfigNode& node, const char* key) {
  const auto numbers = node.Numbers(key, kChannels, Range::Positive());
  return {numbers[0], numbers[1], numbers[2]};
}

}  // namespace

SimConfig ReadSim(const ConfigNode& root) {
  const ConfigNode node = root.Map("simulation");
  const ConfigNode believed = root.Map("radiometry");
  const auto number = [&](const char* key, Range range) {
    return node.Has(key) ? node.Number(key, range) : believed.Number(key, range);
  };
  SimConfig sim;
  sim.encoder_resolution =
      RadFromDeg(node.NumberOr("encoder_resolution_deg", 0, Range::Between(0, 1)));
  sim.repeatability = RadFromDeg(node.NumberOr("repeatability_deg", 0, Range::Between(0, 1)));
  sim.light_drift_per_hour = node.NumberOr("light_drift_per_hour", 0, Range::Between(-0.2, 0.2));
  sim.monitor_noise = number("monitor_noise", Range::Between(0, 1));
  sim.multiplicative_noise = number("multiplicative_noise", Range::Between(0, 1));
  sim.read_noise = number("read_noise_e", Range::NonNegative());
  sim.dark_current = number("dark_current_e_s", Range::NonNegative());
  sim.full_well = node.NumberOr("full_well_e", 0, Range::NonNegative());
  sim.shot_noise = node.BoolOr("shot_noise", true);
  sim.black_level = node.IntegerOr("black_level_counts", 0, 0, 16384);
  sim.responsivity = ReadRgb(node.Has("responsivity") ? node : believed, "responsivity");
  sim.electrons_per_count = number("electrons_per_count", Range::Positive());
  return sim;
}

}  // namespace gonio
