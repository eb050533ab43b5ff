// SPDX-License-Identifier: Apache-2.0
// How true f_r is: calibrated simulated cameras against what they look at. Tables on standard
// output.
//
//   gonio_radiometric_truth [CALIBRATIONS [POSES]]
//
// Every calibration is all five steps anew, on the camera of configs/sim-imperfect.yaml with noise
// of its own (seed = its number), then POSES measurements of each sample (seeds 1000 x calibration
// + number). TMPDIR on a disk in memory makes it quick: the steps write through to the disk.

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <vector>

#include "brdf/analytic.h"
#include "brdf/open.h"
#include "tests/benchmarks/calibrated_camera.h"

namespace gonio {
namespace {

struct Sample {
  std::string name;
  std::shared_ptr<const Brdf> brdf;
  DirectionPair pair;
};

std::vector<Sample> Samples() {
  std::vector<Sample> samples;
  const auto add = [&](std::string name, std::shared_ptr<const Brdf> brdf, double h, double d) {
    samples.push_back({std::move(name), std::move(brdf), PairDeg(h, d)});
  };
  for (const double f_r : {1e-4, 1e-3, 1e-2, 0.05, 0.3, 1.0, 10.0, 100.0, 1000.0}) {
    add(fmt::format("even, {:g} /sr", f_r), std::make_shared<EvenBrdf>(f_r), 25, 30);
  }
  const auto material = [](const char* file) {
    return std::shared_ptr<const Brdf>(OpenBrdf(kConfigs + "materials/" + file));
  };
  add("white tile, 45:0", material("ptfe.yaml"), 22.5, 22.5);
  add("satin paint, peak", material("satin-paint.yaml"), 1, 30);
  add("satin paint, off", material("satin-paint.yaml"), 40, 20);
  add("glossy plastic, peak", material("glossy-plastic.yaml"), 0.5, 30);
  add("glossy plastic, flank", material("glossy-plastic.yaml"), 5, 30);
  const auto mirror = std::make_shared<AnalyticBrdf>(
      "mirror", std::vector<Layer>{Ggx{.roughness = 0.02, .f0 = Rgb::Constant(0.9), .ior = 0}});
  add("mirror (alpha 0.02), peak", mirror, 0.2, 30);
  add("mirror (alpha 0.02), flank", mirror, 2, 30);
  return samples;
}

void PrintTruth(const Setting& setting, const std::vector<Calibrations>& calibrations, int poses) {
  fmt::print(
      "| sample | without: bias % | bias % | scatter % | stated random, systematic % | z mean | z "
      "deviation |\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  const Calibrations none;
  for (const Sample& sample : Samples()) {
    Tally with, without;
    for (std::size_t i = 0; i < calibrations.size(); ++i) {
      for (int p = 0; p < poses; ++p) {
        const std::uint64_t seed = 1000 * (i + 1) + static_cast<unsigned>(p);
        Measure(setting, calibrations[i], *sample.brdf, sample.pair, seed, &with);
        if (i == 0) Measure(setting, none, *sample.brdf, sample.pair, seed, &without);
      }
    }
    fmt::print("| {} | {:.2f} | {:.3f} | {:.2f} | {:.2f}, {:.2f} | {:.2f} | {:.2f} |\n",
               sample.name, 100 * without.bias(), 100 * with.bias(), 100 * with.scatter(),
               100 * with.random / with.n, 100 * with.systematic / with.n, with.z_mean(),
               with.z_deviation());
  }
}

struct Scores {
  std::vector<double> values;
  void Add(double z) { values.push_back(z); }
  std::string Text() const {
    double sum = 0, squares = 0;
    for (const double z : values) {
      sum += z;
      squares += z * z;
    }
    const auto n = static_cast<double>(values.size());
    return fmt::format("{:.2f} | {:.2f}", sum / n, std::sqrt(squares / n - sum * sum / n / n));
  }
};

void PrintSensor(const Setting& setting, int n) {
  Setting linear = setting;
  linear.truth.nonlinearity = 0;
  Scores gain, read, well;
  double relative = 0;
  for (int i = 0; i < n; ++i) {
    const Calibrations found = Calibrate(linear, 500 + static_cast<unsigned>(i));
    const SensorCalibration& sensor = *found.sensor;
    gain.Add((sensor.gain.value - linear.truth.electrons_per_count) / sensor.gain.sigma);
    read.Add((sensor.read_noise.value - linear.truth.read_noise) / sensor.read_noise.sigma);
    const double full = (linear.rig.camera.full_scale - linear.truth.black_level) *
                        linear.truth.electrons_per_count;
    well.Add((sensor.full_well.value - full) / sensor.full_well.sigma);
    relative += sensor.gain.relative() / n;
  }
  fmt::print("\n| photon transfer | z mean | z deviation |\n|---|---|---|\n");
  fmt::print("| gain (stated {:.2f} %) | {} |\n| read noise | {} |\n| full well | {} |\n",
             100 * relative, gain.Text(), read.Text(), well.Text());
}

struct Fault {
  const char* name;
  std::function<void(Setting&)> plant;
};

// One imperfection at a time, on a rig that is right about everything else.
void PrintFaults(const Setting& setting, int calibrations, int poses) {
  Setting clean = setting;
  const SimConfig& was = setting.truth;
  clean.truth.prnu = clean.truth.dsnu = clean.truth.dark_spread = clean.truth.hot_pixels = 0;
  clean.truth.nonlinearity = clean.truth.stray_light = clean.truth.light_drift_per_hour = 0;
  RadiometryConfig& believed = clean.rig.radiometry;
  believed.responsivity = was.responsivity;
  believed.electrons_per_count = was.electrons_per_count;
  believed.dark_current = was.dark_current;
  const Fault faults[] = {
      {"none", [](Setting&) {}},
      {"prnu 2 %", [&](Setting& s) { s.truth.prnu = was.prnu; }},
      {"hot pixels 0.5 %, 3000 e/s", [&](Setting& s) { s.truth.hot_pixels = was.hot_pixels; }},
      {"non-linearity 3 %", [&](Setting& s) { s.truth.nonlinearity = was.nonlinearity; }},
      {"dark current 20 e/s, believed 5", [](Setting& s) { s.rig.radiometry.dark_current = 5; }},
      {"offsets of 6 e, dark spread 30 %",
       [&](Setting& s) {
         s.truth.dsnu = was.dsnu;
         s.truth.dark_spread = was.dark_spread;
       }},
      {"stray light 60 e/s", [&](Setting& s) { s.truth.stray_light = was.stray_light; }},
      {"light drifts by 20 % an hour", [](Setting& s) { s.truth.light_drift_per_hour = 0.2; }},
      {"responsivity 5 % low", [](Setting& s) { s.rig.radiometry.responsivity *= 0.95; }},
  };
  fmt::print(
      "\n| planted | 0.003 /sr: before, after % | 0.3 /sr: before, after % |\n|---|---|---|\n");
  for (const Fault& fault : faults) {
    Setting with = clean;
    fault.plant(with);
    std::vector<Tally> before(2), after(2);
    const double levels[] = {0.003, 0.3};
    for (int i = 0; i < calibrations; ++i) {
      const Calibrations found = Calibrate(with, 900 + static_cast<unsigned>(i));
      for (std::size_t l = 0; l < 2; ++l) {
        const EvenBrdf sample(levels[l]);
        for (int p = 0; p < poses; ++p) {
          const std::uint64_t seed = 5000 * static_cast<unsigned>(i + 1) + static_cast<unsigned>(p);
          Measure(with, found, sample, PairDeg(25, 30), seed, &after[l]);
          Measure(with, {}, sample, PairDeg(25, 30), seed, &before[l]);
        }
      }
    }
    fmt::print("| {} | {:.2f}, {:.2f} | {:.2f}, {:.2f} |\n", fault.name, 100 * before[0].bias(),
               100 * after[0].bias(), 100 * before[1].bias(), 100 * after[1].bias());
  }
}

}  // namespace
}  // namespace gonio

int main(int argc, char** argv) {
  const int calibrations = argc > 1 ? std::atoi(argv[1]) : 30;
  const int poses = argc > 2 ? std::atoi(argv[2]) : 10;
  const gonio::Setting setting = gonio::Imperfect();
  std::vector<gonio::Calibrations> all;
  for (int i = 0; i < calibrations; ++i) {
    all.push_back(gonio::Calibrate(setting, 1 + static_cast<unsigned>(i)));
  }
  gonio::PrintTruth(setting, all, poses);
  gonio::PrintSensor(setting, calibrations);
  gonio::PrintFaults(setting, (calibrations + 9) / 10, 10 * poses);
  return 0;
}
