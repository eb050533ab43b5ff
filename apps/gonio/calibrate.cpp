// SPDX-License-Identifier: Apache-2.0
// gonio calibrate: one step of a calibration, or what there is of one.

#include <fmt/format.h>

#include <ctime>
#include <stdexcept>
#include <utility>

#include "acquisition/calibration/calibration_status.h"
#include "acquisition/calibration/steps.h"
#include "acquisition/geometry_calibration/geometry_file.h"
#include "acquisition/time_model/time_model.h"
#include "apps/gonio/build_rig.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/device_error.h"
#include "apps/gonio/interrupt.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/progress.h"
#include "core/error.h"
#include "core/units.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

using Step = Result<StepReport> (*)(const StepParts&, const StepOptions&);

Step StepNamed(const std::string& name) {
  if (name == "darks") return CalibrateDarks;
  if (name == "photon-transfer") return CalibratePhotonTransfer;
  if (name == "flat") return CalibrateFlat;
  if (name == "stray-light") return CalibrateStrayLight;
  if (name == "glare") return CalibrateGlare;
  return CalibrateStandard;
}

// What a simulated camera has before it in each step, if the user does not say.
std::string UsuallyMounted(const std::string& step) {
  return step == "stray-light" ? "trap.yaml" : "ptfe.yaml";
}

fs::path FolderOf(const CalibrateOptions& options, const RigConfig& rig) {
  if (!options.out.empty()) return options.out;
  if (!rig.calibration.folder.empty()) return rig.calibration.folder;
  throw ConfigError("the rig has no calibration.folder; name one with --out");
}

StepOptions StepOptionsOf(const CalibrateOptions& options, const RigConfig& rig) {
  StepOptions step;
  step.folder = FolderOf(options, rig);
  if (options.theta_i_deg) step.theta_i = RadFromDeg(*options.theta_i_deg);
  if (options.theta_o_deg) step.theta_o = RadFromDeg(*options.theta_o_deg);
  step.frames = options.frames;
  step.trap_radius = options.trap_radius_mm / 1000;
  step.again = options.again;
  step.keep_frames = options.keep_frames;
  if (!options.standard.empty()) step.standard = LocateConfig(options.standard);
  step.now = std::time(nullptr);
  return step;
}

// What a simulated camera sees of a tile with a trap is no material.
void MountTrap(const StepOptions& step, RigFile& rig) {
  rig.simulation.target.kind = SimTarget::Kind::kTrap;
  rig.simulation.target.hole =
      step.trap_radius > 0 ? step.trap_radius : rig.config.imaging.patch_radius;
}

OpenedRig Open(const RigFile& rig, const Brdf* sample, std::uint64_t seed) {
  if (rig.config.simulated) return OpenSimulated(rig, *sample, seed);
  return OpenReal(rig, sample, seed, std::make_unique<SystemClock>());
}

int Failed(const Error& error, const OpenedRig& rig) {
  if (error.code == ErrorCode::kCancelled) {
    fmt::print(stderr, "gonio: {}; the same command goes on with the frames that are kept\n",
               error.message);
    return kStoppedByUser;
  }
  if (error.code == ErrorCode::kRefused) throw std::runtime_error(error.message);
  fmt::print(stderr, "gonio: {}\n", error.message);
  if (rig.wires) fmt::print(stderr, "{}", LastOnTheWires(*rig.wires));
  return kDeviceFaultExit;
}

}  // namespace

int CalibrateCommand(const CalibrateOptions& options) {
  RigFile rig_file = LoadRig(LocateConfig(options.rig));
  StepOptions step = StepOptionsOf(options, rig_file.config);
  std::unique_ptr<Brdf> sample;
  if (rig_file.config.camera_device.driver == CameraDevice::Driver::kSimulated) {
    const std::string mounted =
        options.material.empty() ? UsuallyMounted(options.step) : options.material;
    sample = OpenAny(LocateConfig(mounted));
    if (options.step == "glare") MountTrap(step, rig_file);
    if (options.step != "darks") {
      fmt::print("mounted          {}\n",
                 options.step == "glare" ? "a black trap in a white tile" : sample->name());
    }
  }
  OpenedRig rig = Open(rig_file, sample.get(), options.seed);
  const Interrupt interrupt;
  step.stop = interrupt.after_pose();
  ProgressLine line(options.step, options.quiet);
  step.progress = [&](int done, int total, const std::string& what) {
    line.Show(done, total, what);
  };
  const auto report = StepNamed(options.step)({rig_file.config, rig.devices, *rig.clock}, step);
  line.Finish();
  if (!report) return Failed(report.error(), rig);
  for (const std::string& text : report->lines) fmt::print("{}\n", text);
  for (const fs::path& file : report->files) fmt::print("wrote            {}\n", file.string());
  return kDone;
}

int CalibrateStatusCommand(const CalibrateOptions& options) {
  const RigConfig rig = LoadRig(LocateConfig(options.rig)).config;
  CalibrationPolicy policy = rig.calibration;
  policy.folder = FolderOf(options, rig);
  const std::int64_t now = std::time(nullptr);
  std::string camera;
  for (const CalibrationStatus& status : StatusOf(policy, now)) {
    const char* const name = ToString(status.kind);
    if (!status.problem.empty()) {
      fmt::print("{:<16} cannot be used: {}\n", name, status.problem);
      continue;
    }
    if (!status.header) {
      fmt::print("{:<16} missing; {} makes it\n", name, CommandFor(status.kind));
      continue;
    }
    const SensorFormat& format = status.header->format;
    const std::string seen =
        fmt::format("{}, {} x {} px at {}, {}, {}", format.camera, format.width, format.height,
                    format.left, format.top, ToString(format.layout));
    if (seen != camera) fmt::print("{:<16} {}\n", "for camera", seen);
    camera = seen;
    const double days = static_cast<double>(now - status.header->created) / 86400;
    fmt::print("{:<16} {:.1f} days{}: {}\n", name, days, status.old ? ", too old" : "",
               status.numbers);
  }
  for (const auto& [name, file] : {std::pair{"geometry", kGeometryFile}, {"time", kTimeFile}}) {
    const fs::path path = policy.folder / file;
    if (!fs::exists(path)) {
      fmt::print("{:<16} missing; gonio calibrate {} makes it\n", name, name);
      continue;
    }
    fmt::print("{:<16} made {}\n", name, ConfigNode::Load(path).TextOr("created_utc", "some day"));
  }
  return kDone;
}

}  // namespace gonio
