// SPDX-License-Identifier: Apache-2.0
// Sessions of an RGB camera against those of a mono camera with a light that has colours, on the
// same sample: bias and scores of f_r in each channel, frames and time.
//
//   gonio_colour_truth [SEEDS]

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "acquisition/session.h"
#include "acquisition/session_costs.h"
#include "planner/plan.h"
#include "tests/acquisition/simulated_rig.h"
#include "tests/benchmarks/materials.h"

namespace gonio {
namespace {

constexpr int kPoses = 60;

// What a row of the table is about.
struct Case {
  std::string name;
  RigConfig rig;
  SimConfig truth;
};

std::vector<Case> Cases() {
  const SimConfig leds = ReadSim(ConfigNode::Load(kLedRigFile));
  SimConfig mixed = leds;
  mixed.colour_crosstalk = 0.02;
  return {{"RGB camera", DefaultRig(), DefaultTruth()},
          {"mono, three LEDs", LedRig(), leds},
          {"mono, filter wheel", WheelRig(), leds},
          {"mono, LEDs with 2 % crosstalk", LedRig(), mixed}};
}

// All samples of some sessions.
struct Sums {
  std::vector<Rgb> misses;  // relative
  std::vector<Rgb> scores;
  double sigma[kChannels] = {};  // relative, summed
  double poses = 0;
  double frames = 0;
  double seconds = 0;

  void Add(const SessionSummary& summary, const Brdf& sample) {
    for (const BrdfSample& s : summary.Samples()) {
      const Rgb f_r = *sample.Eval(s.directions);
      misses.emplace_back(s.f_r / f_r - 1);
      scores.emplace_back((s.f_r - f_r) / s.sigma);
      for (int c = 0; c < kChannels; ++c) sigma[c] += s.sigma[c] / f_r[c];
    }
    poses += static_cast<double>(summary.poses.size());
    frames += summary.frames;
    seconds += summary.duration.count();
  }
};

SessionSummary RunOnce(const Case& of, const Brdf& sample, std::uint64_t seed) {
  Plan plan = LoadPlan(GONIO_SOURCE_DIR "/configs/plan-information.yaml");
  plan.max_poses = kPoses;
  const Kinematics kinematics(of.rig);
  const auto planner = MakePlanner(
      plan, {.reachable = [&](const DirectionPair& pair) { return kinematics.Reachable(pair); },
             .costs = CostsOn(of.rig),
             .noise = NoiseOn(of.rig),
             .parts = {},
             .seed = seed});
  SimulatedRig rig(sample, seed, of.rig, of.truth);
  SessionSummary summary = RunSession(
      {rig.rig, rig.devices, rig.clock, *planner, nullptr, nullptr, nullptr, nullptr, rig.draw},
      {});
  if (summary.outcome != SessionOutcome::kComplete) throw std::runtime_error(summary.reason);
  return summary;
}

// Mean and standard deviation of one channel.
std::pair<double, double> MeanOf(const std::vector<Rgb>& values, int c) {
  double sum = 0, squares = 0;
  for (const Rgb& value : values) {
    sum += value[c];
    squares += value[c] * value[c];
  }
  const auto n = static_cast<double>(values.size());
  return {sum / n, std::sqrt((squares - sum * sum / n) / (n - 1))};
}

void PrintRow(const std::string& name, const Sums& sums, const Sums& first) {
  std::string bias, scores, sigmas;
  for (int c = 0; c < kChannels; ++c) {
    const char* const comma = c == 0 ? "" : ", ";
    bias += fmt::format("{}{:.2f}", comma, 100 * MeanOf(sums.misses, c).first);
    scores += fmt::format("{}{:.2f}", comma, MeanOf(sums.scores, c).second);
    sigmas += fmt::format("{}{:.2f}", comma, 100 * sums.sigma[c] / sums.poses);
  }
  const double error = 100 * MeanOf(sums.misses, 1).second / std::sqrt(sums.poses);
  fmt::print("| {} | {} (+- {:.2f}) | {} | {} | {:.2f} | {:.1f} | {:.2f} |\n", name, bias, error,
             scores, sigmas, sums.frames / sums.poses, sums.seconds / sums.poses,
             sums.seconds / first.seconds);
}

void Compare(const std::string& material, const Brdf& sample, int seeds) {
  fmt::print("\n{}\n\n", material);
  fmt::print(
      "| | bias %, red, green, blue | z deviation | mean sigma % | frames a pose | s a pose | time "
      "over RGB's |\n|---|---|---|---|---|---|---|\n");
  Sums first;
  for (const Case& of : Cases()) {
    Sums sums;
    for (int seed = 1; seed <= seeds; ++seed) {
      sums.Add(RunOnce(of, sample, static_cast<std::uint64_t>(seed)), sample);
    }
    if (first.poses == 0) first = sums;
    PrintRow(of.name, sums, first);
  }
}

}  // namespace
}  // namespace gonio

int main(int argc, char** argv) {
  using namespace gonio;
  const int seeds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 8;
  Compare("satin paint", SatinPaint(), seeds);
  const AnalyticBrdf blue("dark blue cloth", {Lambert{Rgb(0.01, 0.03, 0.3)}});
  Compare("dark blue cloth: albedo 0.01, 0.03, 0.3", blue, seeds);
  return 0;
}
