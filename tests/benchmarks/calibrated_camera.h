// SPDX-License-Identifier: Apache-2.0
// The camera of configs/sim-imperfect.yaml, calibrated, and what it is worth.

#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "acquisition/calibration/steps.h"
#include "acquisition/measure.h"
#include "acquisition/radiometry.h"
#include "core/units.h"
#include "sim/random.h"
#include "sim/sim_rig.h"
#include "tests/core/temp_dir.h"

namespace gonio {

inline constexpr std::int64_t kToday = 1'700'000'000;
inline constexpr int kCertificateStream = 77;
inline const std::string kConfigs = std::string(GONIO_SOURCE_DIR) + "/configs/";

class EvenBrdf final : public Brdf {
 public:
  explicit EvenBrdf(double f_r) : f_r_(Rgb::Constant(f_r)) {}
  std::optional<Rgb> Eval(const HalfDiff&) const override { return f_r_; }
  std::string name() const override { return "even"; }

 private:
  const Rgb f_r_;
};

// A simulated instrument, opened.
struct Instrument {
  Instrument(const RigConfig& config, const SimConfig& truth, const Brdf& sample,
             std::uint64_t seed)
      : rig(config) {
    SimDevices sim = MakeSimDevices(
        truth, {rig.axes, rig.motion.home_limit, rig.camera, rig.imaging}, sample, clock, seed);
    devices = {std::move(sim.axes), std::move(sim.camera), std::move(sim.light),
               std::move(sim.monitor)};
  }
  ManualClock clock;
  RigConfig rig;
  Devices devices;
};

template <typename T>
T Must(Result<T> result) {
  if (result) return std::move(result).value();
  fmt::print(stderr, "{}\n", result.error().message);
  std::exit(1);
}

struct Setting {
  RigConfig rig;
  SimConfig truth;
};

inline Setting Imperfect() {
  const ConfigNode root = ConfigNode::Load(kConfigs + "sim-imperfect.yaml");
  return {ReadRig(root, ""), ReadSim(root)};
}

// All steps, with noise and a certificate's error of `seed`. `trap_radius` [m]: of a trap for the
// lens's glare; 0: that step is left out.
inline Calibrations Calibrate(const Setting& setting, std::uint64_t seed, double trap_radius = 0) {
  const TempDir dir;
  // The certificate's half per cent (k = 1) is what it is wrong by.
  const EvenBrdf tile(0.98 / kPi * (1 + 0.005 * Random(seed, kCertificateStream).Normal()));
  const EvenBrdf trap(0);
  StepOptions options;
  options.folder = dir.path() / "cal";
  options.standard = kConfigs + "standard-ptfe.yaml";
  options.now = kToday;
  SimConfig truth = setting.truth;
  const auto step = [&](auto function, const Brdf& mounted, int n) {
    Instrument instrument(setting.rig, truth, mounted, 5 * seed + static_cast<unsigned>(n));
    (void)Must(function({instrument.rig, instrument.devices, instrument.clock}, options));
  };
  step(CalibrateDarks, trap, 0);
  step(CalibratePhotonTransfer, tile, 1);
  step(CalibrateFlat, tile, 2);
  step(CalibrateStrayLight, trap, 3);
  if (trap_radius > 0) {
    options.trap_radius = truth.target.hole = trap_radius;
    truth.target.kind = SimTarget::Kind::kTrap;
    step(CalibrateGlare, trap, 100000);
    truth = setting.truth;
  }
  step(CalibrateStandard, tile, 4);
  Instrument instrument(setting.rig, setting.truth, trap, seed);
  CalibrationPolicy policy;
  policy.folder = options.folder;
  return LoadCalibrations(
      policy, SensorFormatOf(setting.rig, instrument.devices.camera->identity()), kToday);
}

// Sums of z and of relative errors.
struct Tally {
  double n = 0, relative = 0, squares = 0, z = 0, z_squares = 0, random = 0, systematic = 0;
  void Add(double f_r, double truth, double sigma, double sigma_systematic) {
    const double error = f_r / truth - 1;
    n += 1;
    relative += error;
    squares += error * error;
    const double score = (f_r - truth) / std::hypot(sigma, sigma_systematic);
    z += score;
    z_squares += score * score;
    random += sigma / truth;
    systematic += sigma_systematic / truth;
  }
  double bias() const { return relative / n; }
  double scatter() const { return std::sqrt(std::max(0.0, squares / n - bias() * bias())); }
  double z_mean() const { return z / n; }
  double z_deviation() const {
    return std::sqrt(std::max(0.0, z_squares / n - z_mean() * z_mean()));
  }
};

inline void Measure(const Setting& setting, const Calibrations& calibrations, const Brdf& sample,
                    const DirectionPair& pair, std::uint64_t seed, Tally* tally) {
  RigConfig rig = setting.rig;
  Believe(calibrations, &rig);
  Instrument instrument(rig, setting.truth, sample, seed);
  PoseMeasurer measurer(instrument.rig, instrument.devices, instrument.clock,
                        calibrations.bad_pixels ? &calibrations.bad_pixels->mask : nullptr);
  if (!measurer.Prepare({})) return;
  const auto record = measurer.Measure(pair, sample.Eval(pair), {});
  if (!record) return;
  const auto reduced = Must(Reduce(*record, instrument.rig, calibrations));
  const Rgb systematic = reduced.front().budget.systematic();
  const BrdfSample& got = reduced.front().sample;
  const Rgb truth = *sample.Eval(got.directions);
  for (int c = 0; c < kChannels; ++c) {
    if (std::isfinite(got.sigma[c])) tally->Add(got.f_r[c], truth[c], got.sigma[c], systematic[c]);
  }
}

inline DirectionPair PairDeg(double theta_h, double theta_d, double phi_d = 90) {
  return ToDirections({RadFromDeg(theta_h), RadFromDeg(theta_d), RadFromDeg(phi_d)});
}

}  // namespace gonio
