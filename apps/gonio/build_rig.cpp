// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/build_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <mutex>
#include <optional>
#include <utility>

#include "acquisition/geometry_calibration/geometry_file.h"
#include "acquisition/path_planner.h"
#include "acquisition/time_model/time_model.h"
#include "apps/gonio/device_error.h"
#include "core/check.h"
#include "core/config.h"
#include "core/file.h"
#include "drivers/filter_wheel_light.h"
#include "sim/sim_camera.h"
#include "sim/sim_rig.h"

namespace gonio {

namespace {

namespace fs = std::filesystem;

// The calibration's board and mirror are looked at by arms that go round them.
void RefuseUncalibrated(const RigConfig& rig, const std::string& path) {
  if (rig.geometry.kind == RigKind::kFourAxisArms) return;
  throw ConfigError(fmt::format("{}: is of a rig of four-axis-arms, \"{}\" is a {}", path, rig.name,
                                ToString(rig.geometry.kind)));
}

// The camera is compared when it is opened: until then, it is whatever the file says.
void UseGeometryFile(const fs::path& path, RigFile& file) {
  RefuseUncalibrated(file.config, path.string());
  file.calibrated_camera = ConfigNode::Load(path).Text("camera");
  UseGeometry(
      ReadGeometry(path, SensorFormatOf(file.config, file.calibrated_camera), std::time(nullptr)),
      file.config);
}

void UseCalibrations(RigFile& file) {
  const fs::path& folder = file.config.calibration.folder;
  if (folder.empty()) return;
  if (fs::exists(folder / kGeometryFile)) UseGeometryFile(folder / kGeometryFile, file);
  if (fs::exists(folder / kTimeFile))
    file.config.time_model = ReadTimes(folder / kTimeFile, file.config.axis_names());
}

FilterWheelSettings FiltersOf(const RigConfig& config) {
  return {.positions = config.filter_wheel->positions, .retries = config.motion.retries};
}

std::optional<SimWheel> SimWheelOf(const RigConfig& config) {
  if (!config.filter_wheel) return std::nullopt;
  return SimWheel{config.filter_wheel->limits, FiltersOf(config)};
}

void CheckCalibratedCamera(const RigFile& file, const Camera& camera) {
  if (file.calibrated_camera.empty() || file.calibrated_camera == camera.identity()) return;
  throw ConfigError(fmt::format("{}: is of camera {}, this is {}",
                                (file.config.calibration.folder / kGeometryFile).string(),
                                file.calibrated_camera, camera.identity()));
}

}  // namespace

RigFile LoadRig(const std::filesystem::path& path, CalibrationUse use,
                const std::filesystem::path& folder) {
  return ParseRig(ReadTextFile(path), path, use, folder);
}

RigFile ParseRig(const std::string& text, const std::filesystem::path& path, CalibrationUse use,
                 const std::filesystem::path& folder) {
  const ConfigNode root = ConfigNode::Parse(text, path.string());
  RigFile file;
  file.config = ReadRig(root, text);
  file.simulation = ReadSim(root);
  file.interlocks = ReadInterlocks(root, path.parent_path());
  root.RefuseUnknownKeys();
  file.built = file.config.imaging;
  if (!folder.empty()) file.config.calibration.folder = folder;
  if (use == CalibrationUse::kUsed) UseCalibrations(file);
  return file;
}

OpenedRig OpenSimulated(const RigFile& file, const Brdf& sample, std::uint64_t seed,
                        Seconds begin) {
  OpenedRig rig;
  rig.clock = std::make_unique<WatchedClock>(std::make_unique<ManualClock>(begin));
  const SimSetup setup{.axes = file.config.axes,
                       .home_limit = file.config.motion.home_limit,
                       .camera = file.config.camera,
                       .imaging = file.built,
                       .gain_db = 0,
                       .leds = file.config.colour_channels.has_value(),
                       .wheel = SimWheelOf(file.config)};
  SimDevices sim = MakeSimDevices(file.simulation, setup, sample, *rig.clock, seed);
  rig.devices = {.axes = std::move(sim.axes),
                 .camera = std::move(sim.camera),
                 .light = std::move(sim.light),
                 .monitor = std::move(sim.monitor)};
  rig.draw = std::move(sim.draw);
  rig.identities = IdentitiesOf(rig.devices);
  CheckCalibratedCamera(file, *rig.devices.camera);
  return rig;
}

namespace {

// Streams of the generators of simulated devices on a real rig.
enum Stream { kCameraStream = 20, kMonitorStream = 30 };

[[noreturn]] void Refuse(const std::string& where, const Error& error, const LinkLog& wires) {
  const std::string what = where + ": " + error.message;
  if (error.code == ErrorCode::kRefused) throw ConfigError(what);
  throw DeviceError(what, wires);
}

// Before whatever light was opened.
void OpenWheel(const RigConfig& config, AxisOpener& opener, OpenedRig& rig) {
  if (!config.filter_wheel) return;
  const FilterWheel& wheel = *config.filter_wheel;
  ControllerAxisSettings settings;
  settings.name = "filter_wheel";
  settings.limits = wheel.limits;
  settings.home_limit = config.motion.home_limit;
  auto axis = opener.Open(*wheel.device, settings);
  if (!axis) Refuse(wheel.device->where, axis.error(), *rig.wires);
  rig.devices.light = std::make_unique<FilterWheelLight>(
      std::move(rig.devices.light), std::move(axis).value(), FiltersOf(config));
}

void OpenAxes(const RigConfig& config, AxisOpener& opener, OpenedRig& rig) {
  for (int i = 0; i < config.axis_count; ++i) {
    auto axis = OpenRealAxis(config, i, opener);
    if (!axis) Refuse(config.axis_devices[i]->where, axis.error(), *rig.wires);
    rig.devices.axes[i] = std::move(axis).value();
  }
}

// Those that are not real belong together: a simulated monitor cannot see a real light.
void OpenLightAndMonitor(const RigFile& file, std::uint64_t seed, OpenedRig& rig) {
  const LightDevice& light = file.config.light_device;
  const MonitorDevice& monitor = file.config.monitor_device;
  if (light.driver == LightDevice::Driver::kSimulated) {
    auto lamp = MakeSimLamp(file.simulation, seed);
    if (file.config.colour_channels) lamp->GiveColours(file.simulation.colour_crosstalk);
    rig.devices.light = std::make_unique<SimLight>("light", lamp);
    rig.devices.monitor = std::make_unique<SimMonitor>(
        "monitor", lamp, file.simulation.monitor_noise, *rig.clock, Random(seed, kMonitorStream));
    return;
  }
  auto real_light = OpenLight(light, "light", rig.wires);
  if (!real_light) Refuse(light.where, real_light.error(), *rig.wires);
  rig.devices.light = std::move(real_light).value();
  auto real_monitor = OpenMonitor(monitor, "monitor", rig.wires);
  if (!real_monitor) Refuse(monitor.where, real_monitor.error(), *rig.wires);
  rig.devices.monitor = std::move(real_monitor).value();
}

// What the session reckons with must be what the camera is.
void CheckCamera(const RigConfig& config, const CameraInfo& is) {
  const CameraInfo& said = config.camera;
  const auto refuse = [&](const std::string& what) {
    throw ConfigError(config.camera_device.where + ": " + what);
  };
  if (said.layout != is.layout) {
    refuse(fmt::format("its pixels are {}, camera.layout says {}", ToString(is.layout),
                       ToString(said.layout)));
  }
  if (said.full_scale > is.full_scale) {
    refuse(fmt::format("its counts end at {}, camera.full_scale_counts says {}", is.full_scale,
                       said.full_scale));
  }
  if (said.min_exposure < is.min_exposure || said.max_exposure > is.max_exposure) {
    refuse(
        fmt::format("it exposes {:.6g} to {:.6g} s, camera.min_exposure_s and max_exposure_s say "
                    "{:.6g} to {:.6g}",
                    is.min_exposure.count(), is.max_exposure.count(), said.min_exposure.count(),
                    said.max_exposure.count()));
  }
}

void OpenRealCamera(const RigConfig& config, OpenedRig& rig) {
  auto camera = OpenCamera(config.camera_device, "camera", config.camera.width,
                           config.camera.height, *rig.clock);
  if (!camera) Refuse(config.camera_device.where, camera.error(), *rig.wires);
  CheckCamera(config, (*camera)->info());
  rig.devices.camera = std::move(camera).value();
  rig.genicam = dynamic_cast<const GenicamCamera*>(rig.devices.camera.get());
}

// What the arms and the light say is there to see.
void SimulateCamera(const RigFile& file, const Brdf& sample, std::uint64_t seed, OpenedRig& rig) {
  std::array<Axis*, kAxes> axes{};
  for (int i = 0; i < kAxes; ++i) axes[i] = rig.devices.axes[i].get();
  auto camera = std::make_unique<SimCamera>(
      "camera", file.config.camera, file.simulation, sample,
      std::make_unique<ReadbackScene>(axes, rig.devices.light.get(), file.simulation.axis_offset,
                                      file.simulation.colour_crosstalk),
      *rig.clock, Random(seed, kCameraStream), file.built);
  rig.draw = [seed, c = camera.get()](std::uint64_t number) {
    c->Reseed(Random(Random::Hash(seed, number), kCameraStream));
  };
  rig.devices.camera = std::move(camera);
}

void OpenCameraOf(const RigFile& file, const Brdf* sample, std::uint64_t seed, OpenedRig& rig) {
  if (file.config.camera_device.driver == CameraDevice::Driver::kSimulated) {
    GONIO_CHECK(sample != nullptr, "a simulated camera needs something to look at");
    SimulateCamera(file, *sample, seed, rig);
    return;
  }
  OpenRealCamera(file.config, rig);
  CheckCalibratedCamera(file, *rig.devices.camera);
}

}  // namespace

Result<std::unique_ptr<Axis>> OpenRealAxis(const RigConfig& config, int axis, AxisOpener& opener) {
  ControllerAxisSettings settings;
  settings.name = config.axis_names()[static_cast<std::size_t>(axis)];
  settings.limits = config.axes[axis];
  settings.home_limit = config.motion.home_limit;
  return opener.Open(*config.axis_devices[axis], settings);
}

OpenedRig OpenReal(const RigFile& file, const Brdf* sample, std::uint64_t seed,
                   std::unique_ptr<Clock> clock) {
  OpenedRig rig;
  rig.clock = std::make_unique<WatchedClock>(std::move(clock));
  rig.wires = std::make_shared<LinkLog>(rig.clock.get());
  AxisOpener opener(rig.clock.get(), rig.wires);
  OpenAxes(file.config, opener, rig);
  OpenLightAndMonitor(file, seed, rig);
  OpenWheel(file.config, opener, rig);
  OpenCameraOf(file, sample, seed, rig);
  rig.identities = IdentitiesOf(rig.devices);
  return rig;
}

namespace {

bool WheelSharesALine(const RigConfig& config) {
  if (!config.filter_wheel || !config.filter_wheel->device) return false;
  const std::string& port = config.filter_wheel->device->port.port;
  return std::any_of(config.axis_devices.begin(), config.axis_devices.end(),
                     [&](const auto& axis) { return axis && axis->port.port == port; });
}

}  // namespace

Result<void> Reopen(const RigFile& file, const Brdf* sample, std::uint64_t seed,
                    FailureClass failure, OpenedRig& rig) {
  if (file.config.simulated) return {};
  const bool axes = failure == FailureClass::kAxis;
  if (!axes && WheelSharesALine(file.config)) {
    return Error{
        ErrorCode::kDisconnected,
        "the light cannot be opened anew alone: its filter wheel is on a line of the axes"};
  }
  // A simulated camera looks at the other devices; a real one does not mind the axes.
  const bool simulated = file.config.camera_device.driver == CameraDevice::Driver::kSimulated;
  if (!axes || simulated) {
    rig.devices.camera.reset();
    rig.genicam = nullptr;
  }
  try {
    AxisOpener opener(rig.clock.get(), rig.wires);
    if (axes) {
      for (auto& axis : rig.devices.axes) axis.reset();
    }
    if (!axes || file.config.filter_wheel) {
      rig.devices.light.reset();
      rig.devices.monitor.reset();
    }
    if (axes) OpenAxes(file.config, opener, rig);
    if (!rig.devices.light) {
      OpenLightAndMonitor(file, seed, rig);
      OpenWheel(file.config, opener, rig);
    }
    if (!rig.devices.camera) OpenCameraOf(file, sample, seed, rig);
  } catch (const std::runtime_error& e) {
    return Error{ErrorCode::kDisconnected, e.what()};
  }
  for (const auto& [role, identity] : IdentitiesOf(rig.devices)) {
    if (identity == rig.identities.at(role)) continue;
    return Error{ErrorCode::kProtocol,
                 fmt::format("{}: was {}, is {}", role, rig.identities.at(role), identity)};
  }
  return {};
}

std::map<std::string, std::string> IdentitiesOf(const Devices& devices) {
  std::map<std::string, std::string> identities;
  const auto add = [&](const char* role, const auto& device) {
    if (device) identities[role] = device->identity();
  };
  for (const auto& axis : devices.axes) {
    if (axis) add(axis->name().c_str(), axis);
  }
  add("camera", devices.camera);
  add("light", devices.light);
  add("monitor", devices.monitor);
  return identities;
}

void FitToRig(const RigConfig& rig, Plan& plan) {
  if (IsInPlane(rig.geometry.kind)) plan.StayInPlane();
}

Reachable MeasurablePoses(const RigConfig& rig, const Brdf* sample) {
  // A way is looked for from the pose before: neighbours in a plan's raster are near.
  struct Ways {
    explicit Ways(const RigConfig& config) : kinematics(config), paths(config) {}
    const Kinematics kinematics;
    const PathPlanner paths;
    std::mutex mutex;
    std::optional<AxisPositions> at;  // guarded
  };
  return [ways = std::make_shared<Ways>(rig), sample](const DirectionPair& pair) {
    if (sample != nullptr && !sample->Eval(pair)) return false;
    if (ways->paths.free()) return ways->kinematics.Reachable(pair);
    const std::lock_guard lock(ways->mutex);
    const AxisPositions from = ways->at.value_or(AxisPositions{});
    for (const AxisPositions& to : ways->kinematics.Solutions(pair, from)) {
      if (!ways->paths.Plan(ways->at.value_or(to), to)) continue;
      ways->at = to;
      return true;
    }
    return false;
  };
}

}  // namespace gonio
