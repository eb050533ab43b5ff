// SPDX-License-Identifier: Apache-2.0
// Whole sessions on the default simulated rig, whose clock is virtual: what is timed is our work.
#include <benchmark/benchmark.h>

#include <optional>
#include <string>

#include "acquisition/event_log.h"
#include "acquisition/kinematics.h"
#include "acquisition/session.h"
#include "core/config.h"
#include "core/file.h"
#include "planner/plan.h"
#include "sim/sim_rig.h"
#include "tests/benchmarks/materials.h"

namespace gonio {
namespace {

const std::string kConfigs = GONIO_SOURCE_DIR "/configs/";

// configs/plan-information.yaml on configs/sim-rig.yaml, from the files to the last pose. `log`:
// the folder to keep it in, or none.
SessionSummary RunOnce(std::uint64_t seed, const std::optional<std::filesystem::path>& folder) {
  const std::string rig_file = kConfigs + "sim-rig.yaml";
  const std::string text = ReadTextFile(rig_file);
  const ConfigNode root = ConfigNode::Parse(text, rig_file);
  const RigConfig rig = ReadRig(root, text);
  const Plan plan = LoadPlan(kConfigs + "plan-information.yaml");
  const Kinematics kinematics(rig);
  const auto planner = MakePlanner(
      plan, {.reachable = [&](const DirectionPair& pair) { return kinematics.Reachable(pair); },
             .seed = seed});
  ManualClock clock;
  const SimSetup setup{.axes = rig.axes, .home_limit = rig.motion.home_limit, .camera = rig.camera};
  SimDevices sim = MakeSimDevices(ReadSim(root), setup, SatinPaint(), clock, seed);
  Devices devices{.axes = std::move(sim.axes),
                  .camera = std::move(sim.camera),
                  .light = std::move(sim.light),
                  .monitor = std::move(sim.monitor)};
  if (!folder) return RunSession({rig, devices, clock, *planner}, {});
  SessionInfo info;
  info.seed = seed;
  info.rig_name = rig.name;
  info.rig_text = text;
  info.plan_text = plan.text;
  EventLog log = EventLog::Create(*folder, info);
  return RunSession({rig, devices, clock, *planner, &log}, {});
}

void Report(benchmark::State& state, const SessionSummary& summary) {
  if (summary.outcome != SessionOutcome::kComplete) state.SkipWithError(summary.reason.c_str());
  state.counters["poses"] = static_cast<double>(summary.poses.size());
  state.counters["simulated_s"] = summary.duration.count();
}

void BM_Session100(benchmark::State& state) {
  SessionSummary summary;
  for (auto _ : state) summary = RunOnce(1, {});
  Report(state, summary);
}
BENCHMARK(BM_Session100)->Unit(benchmark::kMillisecond);

// The same with the SQLite log, which makes each pose durable before the planner hears of it.
void BM_Session100Logged(benchmark::State& state) {
  const ScratchFolder scratch;
  SessionSummary summary;
  int run = 0;
  for (auto _ : state) summary = RunOnce(1, scratch / std::to_string(run++));
  Report(state, summary);
}
BENCHMARK(BM_Session100Logged)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gonio
