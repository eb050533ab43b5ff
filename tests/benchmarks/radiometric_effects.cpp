// SPDX-License-Identifier: Apache-2.0
// Drift, glare and late shutters: errors before and after they are measured. Tables on standard
// output.
//
//   gonio_radiometric_effects [REPETITIONS]
//
// Seeds are the repetitions' numbers. TMPDIR on a disk in memory makes it quick.

#include <array>
#include <numeric>
#include <vector>

#include "acquisition/session.h"
#include "planner/sequence_planner.h"
#include "tests/benchmarks/calibrated_camera.h"

namespace gonio {
namespace {

constexpr double kSample = 0.3;  // 1/sr, of the drift
constexpr int kPoses = 2400;     // two hours
constexpr int kEvery = 100;      // poses from visit to visit

// Over and over the same two dozen poses.
std::vector<Candidate> ManyPoses() {
  std::vector<Candidate> poses;
  for (int i = 0; i < kPoses; ++i) {
    const HalfDiff angles{RadFromDeg(5 + 5 * (i % 7)), RadFromDeg(15 + 10 * (i % 4)), kPi / 2};
    poses.push_back({.angles = angles, .directions = ToDirections(angles)});
  }
  return poses;
}

SessionSummary RunSessionOf(const Setting& setting, std::uint64_t seed) {
  const EvenBrdf sample(kSample);
  Instrument instrument(setting.rig, setting.truth, sample, seed);
  std::vector<int> order(kPoses);
  std::iota(order.begin(), order.end(), 0);
  SequencePlanner planner(ManyPoses(), order, "drift");
  return RunSession({instrument.rig, instrument.devices, instrument.clock, planner}, {});
}

// Means of twenty poses each: a quarter of a per cent of noise is left of them.
void AddBlocks(const SessionSummary& session, Tally* tally) {
  constexpr std::size_t kBlock = 20;
  for (std::size_t i = 0; i + kBlock <= session.poses.size(); i += kBlock) {
    double f_r = 0, variance = 0;
    for (std::size_t k = i; k < i + kBlock; ++k) {
      const BrdfSample& sample = session.poses[k].samples.front();
      f_r += sample.f_r[1] / kBlock;
      variance += sample.sigma[1] * sample.sigma[1] / (kBlock * kBlock);
    }
    tally->Add(f_r, kSample, std::sqrt(variance), 0);
  }
}

void PrintDrift(int repetitions) {
  const ConfigNode root = ConfigNode::Load(kConfigs + "sim-rig.yaml");
  Setting setting{ReadRig(root, ""), ReadSim(root)};
  fmt::print(
      "| responsivity, %/h | without: bias, rms % | with visits: bias, rms % | stated at the end % "
      "| z deviation at the end |\n|---|---|---|---|---|\n");
  for (const double slope : {0.0, -0.01, -0.02, -0.05, -0.1}) {
    setting.truth.responsivity_drift_per_hour = slope;
    Tally before, after;
    double stated = 0, squares = 0;
    for (int i = 0; i < repetitions; ++i) {
      const auto seed = static_cast<std::uint64_t>(i + 1);
      setting.rig.drift = {};
      AddBlocks(RunSessionOf(setting, seed), &before);
      setting.rig.drift.every_poses = kEvery;
      const SessionSummary session = RunSessionOf(setting, seed);
      AddBlocks(session, &after);
      const double planted = SlowDrift(slope, session.duration);
      for (int c = 0; c < kChannels; ++c) {
        const double z = (session.gain.value[c] - planted) / session.gain.sigma[c];
        stated += session.gain.sigma[c] / kChannels / repetitions;
        squares += z * z / kChannels / repetitions;
      }
    }
    const auto rms = [](const Tally& t) { return 100 * std::sqrt(t.squares / t.n); };
    fmt::print("| {:g} | {:.2f}, {:.2f} | {:.2f}, {:.2f} | {:.2f} | {:.2f} |\n", 100 * slope,
               100 * before.bias(), rms(before), 100 * after.bias(), rms(after), 100 * stated,
               std::sqrt(squares));
  }
}

// The camera of configs/sim-imperfect.yaml behind a lens.
Setting WithLens(double glare) {
  Setting setting = Imperfect();
  setting.rig.camera.width = setting.rig.camera.height = 64;
  setting.rig.imaging.focal_length = 2000;
  setting.rig.imaging.camera_distance = 0.5;
  setting.rig.imaging.light_distance = 0.8;
  setting.rig.imaging.patch_radius = 0.0024;
  setting.truth.veiling_glare = glare;
  setting.truth.defocus = 0.7;
  return setting;
}

void PrintGlare(int repetitions) {
  constexpr double kHole = 0.004;    // m
  constexpr double kAlbedo = 0.012;  // of a dark patch in white
  fmt::print(
      "\n| glare planted, % | found % (stated) | z deviation | dark patch: before, after % "
      "(stated) |\n|---|---|---|---|\n");
  for (const double glare : {0.0, 0.01, 0.03}) {
    Setting setting = WithLens(glare);
    double found = 0, stated = 0, squares = 0;
    Tally before, after;
    for (int i = 0; i < repetitions; ++i) {
      const auto seed = static_cast<std::uint64_t>(i + 1);
      const Calibrations with = Calibrate(setting, seed, kHole);
      const Calibrations without = Calibrate(setting, seed);
      for (const StrayLight& stray : *with.stray) {
        const double z = (stray.glare.value - glare / (1 + glare)) / stray.glare.sigma;
        found += stray.glare.value / kChannels / repetitions;
        stated += stray.glare.sigma / kChannels / repetitions;
        squares += z * z / kChannels / repetitions;
      }
      Setting patch = setting;
      patch.truth.target.kind = SimTarget::Kind::kTrap;
      patch.truth.target.hole = kHole;
      patch.truth.target.hole_albedo = kAlbedo;
      const EvenBrdf dark(kAlbedo / kPi);
      for (std::uint64_t p = 0; p < 4; ++p) {
        Measure(patch, with, dark, PairDeg(25, 30), 1000 * seed + p, &after);
        Measure(patch, without, dark, PairDeg(25, 30), 1000 * seed + p, &before);
      }
    }
    fmt::print("| {:g} | {:.3f} ({:.3f}) | {:.2f} | {:.1f}, {:.1f} ({:.1f}) |\n", 100 * glare,
               100 * found, 100 * stated, std::sqrt(squares), 100 * before.bias(),
               100 * after.bias(), 100 * after.systematic / after.n);
  }
}

void PrintShutter(int repetitions) {
  fmt::print(
      "\n| exposures late by, us | found (stated) | z deviation | f_r 30 /sr: before, after % "
      "(stated) | 400 /sr: before, after % (stated) |\n|---|---|---|---|---|\n");
  for (const double late : {-10e-6, 0.0, 20e-6, 60e-6}) {
    Setting setting = Imperfect();
    setting.truth.shutter_offset = late;
    double found = 0, stated = 0, squares = 0;
    std::array<Tally, 2> before, after;
    for (int i = 0; i < repetitions; ++i) {
      const auto seed = static_cast<std::uint64_t>(i + 1);
      const Calibrations known = Calibrate(setting, seed);
      Calibrations believing = known;
      believing.sensor->exposure_offset = {0, 0};
      const MeasuredValue& offset = known.sensor->exposure_offset;
      const double z = (offset.value - late) / offset.sigma;
      found += offset.value / repetitions;
      stated += offset.sigma / repetitions;
      squares += z * z / repetitions;
      for (std::size_t l = 0; l < 2; ++l) {
        const EvenBrdf sample(l == 0 ? 30 : 400);
        for (std::uint64_t p = 0; p < 6; ++p) {
          Measure(setting, known, sample, PairDeg(25, 30), 1000 * seed + p, &after[l]);
          Measure(setting, believing, sample, PairDeg(25, 30), 1000 * seed + p, &before[l]);
        }
      }
    }
    fmt::print("| {:.0f} | {:.1f} ({:.1f}) | {:.2f}", 1e6 * late, 1e6 * found, 1e6 * stated,
               std::sqrt(squares));
    for (std::size_t l = 0; l < 2; ++l) {
      fmt::print(" | {:.2f}, {:.2f} ({:.2f})", 100 * before[l].bias(), 100 * after[l].bias(),
                 100 * after[l].systematic / after[l].n);
    }
    fmt::print(" |\n");
  }
}

}  // namespace
}  // namespace gonio

int main(int argc, char** argv) {
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 10;
  gonio::PrintDrift(repetitions);
  gonio::PrintGlare(repetitions);
  gonio::PrintShutter(repetitions);
  return 0;
}
