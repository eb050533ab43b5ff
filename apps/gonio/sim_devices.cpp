// SPDX-License-Identifier: Apache-2.0
// gonio sim-devices: the devices of a real rig, none of which is there, for a program that believes
// they are.

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "apps/gonio/build_rig.h"
#include "apps/gonio/camera_double.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/open_any.h"
#include "core/error.h"
#include "sim/device_bench.h"

namespace gonio {
namespace {

BenchDevices DevicesOf(const std::string& file, const RigConfig& rig) {
  if (rig.simulated) {
    throw ConfigError(file + ": is a simulated rig, which needs no doubles (kind: real)");
  }
  BenchDevices devices;
  for (int i = 0; i < rig.axis_count; ++i) {
    devices.axes.push_back(*rig.axis_devices[i]);
    devices.limits.push_back(rig.axes[i]);
  }
  if (rig.filter_wheel) {
    devices.axes.push_back(*rig.filter_wheel->device);
    devices.limits.push_back(rig.filter_wheel->limits);
  }
  devices.light = rig.light_device;
  devices.monitor = rig.monitor_device;
  return devices;
}

std::vector<std::string> CommandOf(const SimDevicesOptions& options) {
  if (!options.command.empty()) return options.command;
  const char* const shell = std::getenv("SHELL");
  return {shell == nullptr ? "/bin/sh" : shell};
}

// Sees the bench; ends with the command's exit code.
int RunOn(std::vector<std::string> command) {
  ::setenv("LD_PRELOAD", UsbBench::kPreload, 1);
  std::vector<char*> words;
  for (std::string& word : command) words.push_back(word.data());
  words.push_back(nullptr);
  // Ctrl-C is the command's to obey; the devices stay until it ends.
  std::signal(SIGINT, SIG_IGN);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t interrupts;
  sigemptyset(&interrupts);
  sigaddset(&interrupts, SIGINT);
  posix_spawnattr_setsigdefault(&attributes, &interrupts);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, words[0], nullptr, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  ::unsetenv("LD_PRELOAD");
  if (error != 0) {
    throw std::runtime_error(
        fmt::format("{}: cannot be started: {}", words[0], std::strerror(error)));
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : kFailed;
}

// Unplugs the camera after some exposures, and plugs it in again.
void TroubleCamera(GigeCamera& camera, const SimDevicesOptions& options, std::stop_token stop) {
  constexpr Seconds kLook{0.02};
  SystemClock clock;
  while (camera.exposures() < options.camera_gone_after) {
    if (stop.stop_requested()) return;
    clock.SleepFor(kLook, stop);
  }
  camera.Disappear();
  fmt::print(stderr, "sim-devices: the camera is unplugged\n");
  if (options.camera_gone_for_s <= 0) return;
  clock.SleepFor(Seconds(options.camera_gone_for_s), stop);
  if (stop.stop_requested()) return;  // the command has ended without it
  const auto back = camera.Return();
  fmt::print(stderr, "sim-devices: {}\n",
             back.ok() ? "the camera is plugged in again" : back.error().message);
}

void RefuseWithoutCamera(const SimDevicesOptions& options) {
  const std::string why = ": the camera of " + options.rig + " is simulated by the command itself";
  if (!options.material.empty()) throw ConfigError("--material" + why + ", give it there");
  if (options.packet_loss_percent > 0) throw ConfigError("--packet-loss-percent" + why);
  if (options.camera_late_frames > 0) throw ConfigError("--camera-late-frames" + why);
  if (options.camera_chunk_data) throw ConfigError("--camera-chunk-data" + why);
  if (options.camera_gone_after > 0) throw ConfigError("--camera-gone-after" + why);
  if (!options.frames_log.empty()) throw ConfigError("--frames-log" + why);
}

}  // namespace

int SimDevicesCommand(const SimDevicesOptions& options) {
  const RigFile file = LoadRig(LocateConfig(options.rig));
  const BenchDevices devices = DevicesOf(options.rig, file.config);
  const DeviceBench bench(devices, std::make_shared<SystemClock>(options.speed));
  std::unique_ptr<Brdf> sample;
  std::unique_ptr<GigeCamera> camera;
  std::jthread trouble;
  if (file.config.camera_device.driver == CameraDevice::Driver::kSimulated) {
    RefuseWithoutCamera(options);
  } else {
    sample = OpenAny(LocateConfig(options.material.empty() ? kDefaultMaterial : options.material));
    camera = ServeCamera(
        file, bench, *sample,
        {options.speed, options.camera_late_frames, options.camera_chunk_data, options.frames_log});
    camera->SetPacketLoss(options.packet_loss_percent / 100);
    if (options.camera_gone_after > 0) {
      trouble = std::jthread([&](std::stop_token stop) { TroubleCamera(*camera, options, stop); });
    }
  }
  return RunOn(CommandOf(options));
}

}  // namespace gonio
