// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/session_setup.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <ctime>

#include "acquisition/geometry_calibration/geometry_file.h"
#include "acquisition/radiometry/calibration_file.h"
#include "acquisition/session_costs.h"
#include "acquisition/time_model/time_model.h"
#include "apps/gonio/open_any.h"
#include "core/error.h"
#include "core/sha256.h"
#include "core/utc.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

// Adds the ages of those two to `ages`, and what is old by the policy to `old`.
void JudgeTheWhole(const RigConfig& rig, std::int64_t now, std::vector<std::string>* ages,
                   std::vector<std::string>* old) {
  for (const fs::path& file : FilesOfTheWhole(rig)) {
    const ConfigNode root = ConfigNode::Load(file);
    const auto created = SecondsOfUtc(root.Text("created_utc"));
    if (!created) root.Fail("created_utc", "is no time such as 2024-05-03T09:12:44Z");
    const std::string name = file.stem().string();
    ages->push_back(fmt::format("{} {:.1f} days", name, (now - *created) / 86400.0));
    std::string why = WhyTooOld(file, *created, "gonio calibrate " + name, rig.calibration, now);
    if (!why.empty()) old->push_back(std::move(why));
  }
}

}  // namespace

bool HasRealCamera(const RigConfig& rig) {
  return rig.camera_device.driver != CameraDevice::Driver::kSimulated;
}

SessionChoice ChoiceOf(const SessionInfo& info, const fs::path& session) {
  SessionChoice choice;
  choice.rig_path = info.rig_path;
  choice.rig_text = info.rig_text;
  choice.plan_path = info.plan_path;
  choice.plan_text = info.plan_text;
  choice.prior = info.prior_spec;
  choice.material_path = info.material_path;
  choice.seed = info.seed;
  choice.max_poses = info.max_poses;
  choice.use_calibration_of_file = false;
  if (choice.rig_path.empty()) choice.rig_path = session / kSessionFile;
  if (fs::is_directory(session / kSessionCalibration)) {
    choice.calibration = session / kSessionCalibration;
  }
  return choice;
}

const Brdf* SessionSetup::SimulatedSample() const {
  return HasRealCamera(rig.config) ? nullptr : material.get();
}

Reachable SessionSetup::Measurable() const {
  return MeasurablePoses(rig.config, SimulatedSample());
}

SessionSetup SetUp(const SessionChoice& choice) {
  SessionSetup setup;
  const bool uses = choice.use_calibration_of_file || !choice.calibration.empty();
  setup.rig = ParseRig(choice.rig_text, choice.rig_path,
                       uses ? CalibrationUse::kUsed : CalibrationUse::kIgnored, choice.calibration);
  if (!uses) setup.rig.config.calibration.folder.clear();
  setup.plan = ParsePlan(choice.plan_text, choice.plan_path.string());
  FitToRig(setup.rig.config, setup.plan);
  if (choice.max_poses > 0) setup.plan.max_poses = choice.max_poses;
  if (!choice.prior.empty()) {
    setup.plan.Believe(OpenPrior(choice.prior, setup.plan.prior.shape));
  }
  if (!choice.material_path.empty()) setup.material = OpenAny(choice.material_path);
  return setup;
}

std::unique_ptr<Planner> PlannerFor(const SessionSetup& setup, std::uint64_t seed) {
  const RigConfig& rig = setup.rig.config;
  return MakePlanner(setup.plan, {.reachable = setup.Measurable(),
                                  .costs = CostsOn(rig),
                                  .noise = NoiseOn(rig),
                                  .parts = PartsOn(rig),
                                  .seed = seed});
}

OpenedRig Open(const SessionSetup& setup, std::uint64_t seed, Seconds begin) {
  if (setup.rig.config.simulated) return OpenSimulated(setup.rig, *setup.material, seed, begin);
  return OpenReal(setup.rig, setup.SimulatedSample(), seed,
                  std::make_unique<SystemClock>(1, begin));
}

// Files of the calibration folder that say where things are and how long they take.
std::vector<fs::path> FilesOfTheWhole(const RigConfig& rig) {
  std::vector<fs::path> files;
  for (const char* name : {kGeometryFile, kTimeFile}) {
    const fs::path file = rig.calibration.folder / name;
    if (!rig.calibration.folder.empty() && fs::exists(file)) files.push_back(file);
  }
  return files;
}

// Those of the rig's folder, for this camera; says which they are and how old.
Calibrations LoadFor(const RigConfig& rig, const Devices& devices) {
  const CalibrationPolicy& policy = rig.calibration;
  if (policy.folder.empty()) return {};
  const std::int64_t now = std::time(nullptr);
  Calibrations calibrations =
      LoadCalibrations(policy, SensorFormatOf(rig, devices.camera->identity()), now,
                       LightFormatOf(rig, *devices.light));
  std::vector<std::string> ages;
  if (!calibrations.empty()) ages.push_back(AgesOf(calibrations, now));
  std::vector<std::string> old = OldOnes(calibrations, policy, now);
  JudgeTheWhole(rig, now, &ages, &old);
  if (policy.refuse_old && !old.empty()) throw ConfigError(old.front());
  fmt::print("calibration      {}\n",
             ages.empty() ? "none" : fmt::format("{}", fmt::join(ages, ", ")));
  if (!calibrations.responsivity) {
    fmt::print("                 responsivity is the rig file's: no standard was measured\n");
  }
  for (const std::string& one : old) fmt::print(stderr, "gonio: warning: {}\n", one);
  return calibrations;
}

std::string HashOfMaterial(const fs::path& path) {
  return fs::is_regular_file(path) ? Sha256OfFile(path) : std::string();
}

SessionInfo Describe(const SessionChoice& choice, const SessionSetup& setup,
                     const Calibrations& calibrations, const Devices& devices) {
  SessionInfo info;
  info.gonio_version = GONIO_VERSION;
  info.seed = choice.seed;
  info.max_poses = choice.max_poses;
  info.rig_name = setup.rig.config.name;
  info.rig_path = fs::absolute(choice.rig_path).string();
  info.rig_text = choice.rig_text;
  const auto axes = setup.rig.config.axis_names();
  info.axes.assign(axes.begin(), axes.end());
  info.plan_path = fs::absolute(choice.plan_path).string();
  info.plan_text = choice.plan_text;
  info.prior_name = setup.plan.prior.name;
  info.prior_spec = choice.prior;
  info.prior_sha256 = HashOf(setup.plan.prior);
  if (setup.material) {
    info.material_path = fs::absolute(choice.material_path).string();
    info.material_sha256 = HashOfMaterial(choice.material_path);
  }
  for (const CalibrationFile& file : calibrations.files) {
    info.calibrations[FileNameOf(file.kind)] = file.sha256;
  }
  for (const fs::path& file : FilesOfTheWhole(setup.rig.config)) {
    info.calibrations[file.filename().string()] = Sha256OfFile(file);
  }
  info.devices = IdentitiesOf(devices);
  return info;
}

}  // namespace gonio
