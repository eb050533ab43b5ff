// SPDX-License-Identifier: Apache-2.0
// From a rig file to opened devices. The one place that chooses between kinds of rigs.

#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "acquisition/rig.h"
#include "brdf/brdf.h"
#include "core/clock.h"
#include "planner/candidates.h"
#include "sim/sim_config.h"

namespace gonio {

struct RigFile {
  RigConfig config;
  SimConfig simulation;  // kind: simulated
};

// Throws ConfigError naming file, line and key.
RigFile LoadRig(const std::filesystem::path& path);

// Devices with the clock they live by. Destroying it stops the axes and switches the light off.
struct OpenedRig {
  std::unique_ptr<Clock> clock;  // virtual on a simulated rig
  Devices devices;
};

// A simulated rig looks at `sample`, which must outlive it; `seed` is that of its noise.
OpenedRig OpenRig(const RigFile& file, const Brdf& sample, std::uint64_t seed);

// The poses a plan may choose from: those the rig can reach and where the simulated `sample`, which
// must outlive the result, has a reflectance: measured materials end somewhere, and beyond it the
// simulated camera refuses to expose.
Reachable MeasurablePoses(const RigConfig& rig, const Brdf& sample);

}  // namespace gonio
