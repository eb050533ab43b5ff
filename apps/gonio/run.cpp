// SPDX-License-Identifier: Apache-2.0
// gonio run: a session, its fit, and what both were worth.

#include "acquisition/event_log.h"
#include "acquisition/radiometry.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/session_drive.h"
#include "apps/gonio/session_setup.h"
#include "apps/gonio/summary.h"
#include "core/error.h"
#include "core/file.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

SessionChoice ChoiceOf(const RunOptions& options) {
  SessionChoice choice;
  choice.rig_path = LocateConfig(options.rig);
  choice.plan_path = LocateConfig(options.plan);
  choice.prior = options.prior;
  choice.seed = options.seed;
  choice.max_poses = options.max_poses;
  choice.calibration = options.calibration;
  choice.rig_text = ReadTextFile(choice.rig_path);
  choice.plan_text = ReadTextFile(choice.plan_path);
  if (!options.prior.empty() && !IsBuiltInPrior(options.prior)) {
    choice.prior = fs::absolute(options.prior).string();
  }
  // What a real camera looks at nobody knows; a material is then something to compare with.
  const RigFile rig = ParseRig(choice.rig_text, choice.rig_path, CalibrationUse::kIgnored);
  if (!options.material.empty() || !HasRealCamera(rig.config)) {
    choice.material_path =
        LocateConfig(options.material.empty() ? kDefaultMaterial : options.material);
  }
  return choice;
}

void CopyCalibrationsTo(const fs::path& folder, const Calibrations& calibrations,
                        const RigConfig& rig) {
  if (!calibrations.empty()) CopyCalibrations(calibrations, folder);
  for (const fs::path& file : FilesOfTheWhole(rig)) {
    fs::create_directories(folder);
    fs::copy_file(file, folder / file.filename());
  }
}

}  // namespace

int RunCommand(const RunOptions& options) {
  if (!options.resume.empty()) return ResumeSession(options);
  if (options.out.empty()) throw ConfigError("--out is required");
  if (fs::exists(fs::symlink_status(options.out))) {
    throw ConfigError(options.out.string() +
                      ": exists already; a session never reuses a directory, name another");
  }
  const SessionChoice choice = ChoiceOf(options);
  SessionSetup setup = SetUp(choice);
  if (setup.material) WarnIfSeen(setup.plan.prior, choice.material_path.stem().string());
  const DriveOptions drive = DriveOptionsOf(options, setup.rig.config);
  OpenedRig rig = Open(setup, options.seed);
  const Calibrations calibrations = LoadFor(setup.rig.config, rig.devices);
  Believe(calibrations, &setup.rig.config);
  const std::unique_ptr<Planner> planner = PlannerFor(setup, options.seed);
  EventLog log = EventLog::Create(options.out, Describe(choice, setup, calibrations, rig.devices));
  CopyCalibrationsTo(options.out / kSessionCalibration, calibrations, setup.rig.config);
  return DriveSession({setup, rig, calibrations, *planner, log, options.seed}, drive, options.out);
}

}  // namespace gonio
