// SPDX-License-Identifier: Apache-2.0
// configs/sim-imperfect.yaml, opened before a flat sample, and its calibration, done once.

#pragma once

#include <filesystem>

#include "acquisition/calibration/steps.h"
#include "tests/acquisition/simulated_rig.h"
#include "tests/core/temp_dir.h"

namespace gonio {

inline constexpr std::int64_t kToday = 1'700'000'000;  // s since 1970
inline const char* const kImperfectRigFile = GONIO_SOURCE_DIR "/configs/sim-imperfect.yaml";
inline const char* const kStandardFile = GONIO_SOURCE_DIR "/configs/standard-ptfe.yaml";

inline RigConfig ImperfectRig() {
  static const RigConfig rig = ReadRig(ConfigNode::Load(kImperfectRigFile), "");
  return rig;
}
inline SimConfig ImperfectTruth() {
  static const SimConfig truth = ReadSim(ConfigNode::Load(kImperfectRigFile));
  return truth;
}

// The tile of kStandardFile, and nothing at all.
inline const FlatBrdf& WhiteTile() {
  static const FlatBrdf tile(Rgb::Constant(0.98 / kPi));
  return tile;
}
inline const FlatBrdf& Trap() {
  static const FlatBrdf trap(Rgb::Zero());
  return trap;
}

using StepFunction = Result<StepReport> (*)(const StepParts&, const StepOptions&);

// One step on a rig that was just switched on.
inline Result<StepReport> RunStep(StepFunction step, const Brdf& mounted, StepOptions options,
                                  std::uint64_t seed = 1,
                                  const SimConfig& truth = ImperfectTruth()) {
  SimulatedRig rig(mounted, seed, ImperfectRig(), truth);
  if (options.now == 0) options.now = kToday;
  return step({rig.rig, rig.devices, rig.clock}, options);
}

// All steps, in order.
inline void CalibrateAll(const std::filesystem::path& folder, std::uint64_t seed = 1,
                         const SimConfig& truth = ImperfectTruth()) {
  StepOptions options;
  options.folder = folder;
  options.standard = kStandardFile;
  const auto expect = [&](StepFunction step, const Brdf& mounted) {
    const auto report = RunStep(step, mounted, options, seed, truth);
    ASSERT_TRUE(report.ok()) << report.error().message;
  };
  expect(CalibrateDarks, Trap());
  expect(CalibratePhotonTransfer, WhiteTile());
  expect(CalibrateFlat, WhiteTile());
  expect(CalibrateStrayLight, Trap());
  expect(CalibrateStandard, WhiteTile());
}

// Of the rig above, of `seed` 1, once a program.
inline const std::filesystem::path& CalibratedFolder() {
  static const TempDir dir;
  static const std::filesystem::path folder = [] {
    CalibrateAll(dir.path() / "cal");
    return dir.path() / "cal";
  }();
  return folder;
}

inline SensorFormat ImperfectFormat() {
  SensorFormat format;
  format.camera = "simulated";
  format.width = ImperfectRig().camera.width;
  format.height = ImperfectRig().camera.height;
  format.layout = ImperfectRig().camera.layout;
  format.full_scale = ImperfectRig().camera.full_scale;
  return format;
}

inline Calibrations LoadFrom(const std::filesystem::path& folder) {
  CalibrationPolicy policy;
  policy.folder = folder;
  return LoadCalibrations(policy, ImperfectFormat(), kToday);
}

}  // namespace gonio
