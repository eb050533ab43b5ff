// SPDX-License-Identifier: Apache-2.0
// gonio run: a session, its fit, and what both were worth.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <ctime>
#include <stdexcept>

#include "acquisition/calibration/calibrations.h"
#include "acquisition/event_log.h"
#include "acquisition/geometry_calibration/geometry_file.h"
#include "acquisition/radiometry.h"
#include "acquisition/radiometry/calibration_file.h"
#include "acquisition/session.h"
#include "acquisition/session_costs.h"
#include "acquisition/time_estimate.h"
#include "acquisition/time_model/time_model.h"
#include "apps/gonio/build_rig.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/device_error.h"
#include "apps/gonio/interrupt.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/progress.h"
#include "apps/gonio/summary.h"
#include "core/error.h"
#include "core/sha256.h"
#include "core/utc.h"
#include "fitting/fit.h"
#include "fitting/process_fit.h"
#include "planner/plan.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWireLog = "wire.log";

bool HasRealCamera(const RigConfig& rig) {
  return rig.camera_device.driver != CameraDevice::Driver::kSimulated;
}

// Everything that is read and checked before a directory is made or an axis moves.
struct Setup {
  RigFile rig;
  fs::path plan_path;
  Plan plan;
  fs::path material_path;
  std::unique_ptr<Brdf> material;  // null: a real sample, and nothing to compare it with
  std::unique_ptr<Planner> planner;

  // What a simulated camera looks at; null for a real one.
  const Brdf* SimulatedSample() const {
    return HasRealCamera(rig.config) ? nullptr : material.get();
  }
};

Setup Prepare(const RunOptions& options) {
  Setup setup;
  setup.rig = LoadRig(LocateConfig(options.rig), CalibrationUse::kUsed, options.calibration);
  setup.plan_path = LocateConfig(options.plan);
  setup.plan = LoadPlan(setup.plan_path);
  if (options.max_poses > 0) setup.plan.max_poses = options.max_poses;
  if (!options.prior.empty()) {
    setup.plan.Believe(OpenPrior(options.prior, setup.plan.prior.shape));
  }
  // What a real camera looks at nobody knows; a material is then something to compare with.
  if (!options.material.empty() || !HasRealCamera(setup.rig.config)) {
    setup.material_path =
        LocateConfig(options.material.empty() ? kDefaultMaterial : options.material);
    setup.material = OpenAny(setup.material_path);
    WarnIfSeen(setup.plan.prior, setup.material_path.stem().string());
  }
  return setup;
}

std::unique_ptr<Planner> PlannerFor(const Setup& setup, std::uint64_t seed) {
  return MakePlanner(setup.plan,
                     {.reachable = MeasurablePoses(setup.rig.config, setup.SimulatedSample()),
                      .costs = CostsOn(setup.rig.config),
                      .noise = NoiseOn(setup.rig.config),
                      .parts = PartsOn(setup.rig.config),
                      .seed = seed});
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

// Those of the rig's folder, for this camera; says which they are and how old.
Calibrations LoadFor(const RigConfig& rig, const Camera& camera) {
  const CalibrationPolicy& policy = rig.calibration;
  if (policy.folder.empty()) return {};
  const std::int64_t now = std::time(nullptr);
  Calibrations calibrations = LoadCalibrations(policy, SensorFormatOf(rig, camera.identity()), now);
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

SessionInfo Describe(const RunOptions& options, const Setup& setup,
                     const Calibrations& calibrations, const Devices& devices) {
  SessionInfo info;
  info.gonio_version = GONIO_VERSION;
  info.seed = options.seed;
  info.max_poses = options.max_poses;
  info.rig_name = setup.rig.config.name;
  info.rig_text = setup.rig.config.text;
  info.plan_path = fs::absolute(setup.plan_path).string();
  info.plan_text = setup.plan.text;
  info.prior_name = setup.plan.prior.name;
  info.prior_spec = options.prior;
  if (!options.prior.empty() && !IsBuiltInPrior(options.prior)) {
    info.prior_spec = fs::absolute(options.prior).string();
  }
  info.prior_sha256 = HashOf(setup.plan.prior);
  if (setup.material) info.material_path = fs::absolute(setup.material_path).string();
  if (fs::is_regular_file(setup.material_path)) {
    info.material_sha256 = Sha256OfFile(setup.material_path);
  }
  for (const CalibrationFile& file : calibrations.files) {
    info.calibrations[FileNameOf(file.kind)] = file.sha256;
  }
  for (const fs::path& file : FilesOfTheWhole(setup.rig.config)) {
    info.calibrations[file.filename().string()] = Sha256OfFile(file);
  }
  for (int i = 0; i < kAxes; ++i) info.devices[kAxisNames[i]] = devices.axes[i]->identity();
  info.devices["camera"] = devices.camera->identity();
  info.devices["light"] = devices.light->identity();
  info.devices["monitor"] = devices.monitor->identity();
  return info;
}

OpenedRig Open(const Setup& setup, std::uint64_t seed) {
  if (setup.rig.config.simulated) return OpenSimulated(setup.rig, *setup.material, seed);
  return OpenReal(setup.rig, setup.SimulatedSample(), seed, std::make_unique<SystemClock>());
}

void PrintSession(const SessionSummary& s) {
  fmt::print("session          {}: {}\n", ToString(s.outcome), s.reason);
  fmt::print("poses            {} measured with {} frames, {} refused\n", s.poses.size(), s.frames,
             s.rejected);
  fmt::print("time on the rig  {} (homing {}, moving {}, exposing {})\n", ForPeople(s.duration),
             ForPeople(s.preparation), ForPeople(s.travel), ForPeople(s.exposing));
  if (s.predicted_error) fmt::print("predicted error  {:.5f}\n", *s.predicted_error);
}

// What the same instrument would need for a dense scan that exposes as long per pose as this
// session.
void PrintDense(const SessionSummary& s, const RigConfig& rig) {
  const TimeEstimate dense =
      EstimateDenseScan(rig, s.exposing / static_cast<double>(s.poses.size()));
  fmt::print("dense scan       {} for {} poses: {:.1f} times as long\n", ForPeople(dense.total()),
             dense.poses, dense.total() / s.duration);
}

// What went wrong is for standard error; what was measured is safe either way.
void ReportFault(const SessionSummary& summary, const fs::path& out) {
  if (summary.outcome != SessionOutcome::kDeviceFault &&
      summary.outcome != SessionOutcome::kStorageFailed) {
    return;
  }
  fmt::print(stderr, "gonio: {} ({} poses are safe in {})\n", summary.reason, summary.poses.size(),
             out.string());
}

// How much went over each wire, all of which is in DIR/wire.log.
void RecordWires(const LinkLog& wires, const SessionSummary& summary, EventLog& log) {
  for (const auto& [link, count] : wires.Counts()) {
    (void)log.AppendNote(
        summary.duration, "wire",
        fmt::format("{}: {} messages sent, {} bytes, {} received; {} calls failed", link,
                    count.sent, count.bytes_sent, count.bytes_received, count.failures));
  }
}

// "612 frames, 14 taken again (13 missing packets, 1 none), found again 0 times".
std::string TextOf(const GenicamCounters& counters) {
  std::string bad;
  for (const auto& [what, count] : counters.bad) {
    bad += fmt::format("{}{} {}", bad.empty() ? " (" : ", ", count, what);
  }
  if (!bad.empty()) bad += ")";
  return fmt::format(
      "{} frames, {} taken again{}, {} discarded after a change, lost and found {} times",
      counters.frames, counters.retries, bad, counters.discarded, counters.reopened);
}

void FitAndPrint(const SessionSummary& summary, const Setup& setup, const fs::path& out) {
  try {
    const DsbrdfFit fit = FitDsbrdf(summary.Samples(), setup.plan.prior, setup.plan.fit);
    WriteFit(out / kFitFile, fit);
    PrintFit(fit, setup.plan.prior);
    if (setup.material) PrintMale(*setup.material, fit, "the material's file");
    if (setup.material && setup.plan.prior.process) {
      fmt::print("with what DSBRDF cannot say (the process of prior {}):\n", setup.plan.prior.name);
      PrintMale(*setup.material, *FitProcess(summary.Samples(), setup.plan.prior),
                "the material's file");
    }
  } catch (const ConfigError& e) {
    // Not the user's configuration: the measurement gave nothing to fit.
    throw std::runtime_error(
        fmt::format("{}: measured, but cannot be fitted: {}", out.string(), e.what()));
  }
  PrintDense(summary, setup.rig.config);
}

}  // namespace

int RunCommand(const RunOptions& options) {
  if (fs::exists(fs::symlink_status(options.out))) {
    throw ConfigError(options.out.string() +
                      ": exists already; a session never reuses a directory, name another");
  }
  Setup setup = Prepare(options);
  OpenedRig rig = Open(setup, options.seed);
  const Calibrations calibrations = LoadFor(setup.rig.config, *rig.devices.camera);
  Believe(calibrations, &setup.rig.config);
  setup.planner = PlannerFor(setup, options.seed);
  EventLog log = EventLog::Create(options.out, Describe(options, setup, calibrations, rig.devices));
  if (!calibrations.empty()) CopyCalibrations(calibrations, options.out / kSessionCalibration);
  for (const fs::path& file : FilesOfTheWhole(setup.rig.config)) {
    fs::create_directories(options.out / kSessionCalibration);
    fs::copy_file(file, options.out / kSessionCalibration / file.filename());
  }
  if (rig.wires) rig.wires->WriteTo(options.out / kWireLog);

  SessionSummary summary;
  {
    const Interrupt interrupt;
    ProgressLine line("measuring", options.quiet);
    summary =
        RunSession({setup.rig.config, rig.devices, *rig.clock, *setup.planner, &log, &calibrations},
                   {}, {.after_pose = interrupt.after_pose(), .now = interrupt.now()},
                   [&](const Progress& progress) { line.Show(progress); });
  }
  ReportFault(summary, options.out);
  if (rig.genicam != nullptr) {
    const std::string frames = TextOf(rig.genicam->counters());
    (void)log.AppendNote(summary.duration, "camera", frames);
    fmt::print("camera           {}\n", frames);
  }
  rig.devices = {};  // stops and switches off: the last words on their wires
  if (rig.wires) {
    RecordWires(*rig.wires, summary, log);
    if (summary.outcome == SessionOutcome::kDeviceFault) {
      fmt::print(stderr, "{}", LastOnTheWires(*rig.wires));
    }
  }
  const int code = ExitCodeOf(summary.outcome);
  // A full disk has no room for a fit either; the samples can be fitted later.
  if (summary.outcome == SessionOutcome::kStorageFailed) return code;
  PrintSession(summary);
  if (!summary.poses.empty()) FitAndPrint(summary, setup, options.out);
  fmt::print("wrote            {}\n", options.out.string());
  return code;
}

}  // namespace gonio
