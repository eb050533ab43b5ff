// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/build_rig.h"

#include <utility>

#include "acquisition/kinematics.h"
#include "core/check.h"
#include "core/config.h"
#include "core/file.h"
#include "sim/sim_rig.h"

namespace gonio {

RigFile LoadRig(const std::filesystem::path& path) {
  const std::string text = ReadTextFile(path);
  const ConfigNode root = ConfigNode::Parse(text, path.string());
  RigFile file;
  file.config = ReadRig(root, text);
  if (file.config.simulated) file.simulation = ReadSim(root);
  root.RefuseUnknownKeys();
  return file;
}

OpenedRig OpenRig(const RigFile& file, const Brdf& sample, std::uint64_t seed) {
  GONIO_CHECK(file.config.simulated, "ReadRig() lets no other kind pass");
  OpenedRig rig;
  rig.clock = std::make_unique<ManualClock>();
  const SimSetup setup{.axes = file.config.axes,
                       .home_limit = file.config.motion.home_limit,
                       .camera = file.config.camera};
  SimDevices sim = MakeSimDevices(file.simulation, setup, sample, *rig.clock, seed);
  rig.devices = {.axes = std::move(sim.axes),
                 .camera = std::move(sim.camera),
                 .light = std::move(sim.light),
                 .monitor = std::move(sim.monitor)};
  return rig;
}

Reachable MeasurablePoses(const RigConfig& rig, const Brdf& sample) {
  return [kinematics = Kinematics(rig), &sample](const DirectionPair& pair) {
    return kinematics.Reachable(pair) && sample.Eval(pair).has_value();
  };
}

}  // namespace gonio
