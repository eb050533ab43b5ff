// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/camera_double.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "core/sha256.h"
#include "sim/sim_imager.h"
#include "sim/sim_scene.h"

namespace gonio {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr std::uint64_t kCameraStream = 20;

GigeCameraSettings SettingsOf(const RigFile& file, const CameraDoubleOptions& options) {
  const CameraInfo& camera = file.config.camera;
  const GenicamSettings& genicam = file.config.camera_device.genicam;
  GigeCameraSettings settings;
  settings.address = genicam.address;
  // The lens looks at the middle of the sensor, and that is the middle of the region.
  settings.sensor_width = 2 * genicam.offset_x + camera.width;
  settings.sensor_height = 2 * genicam.offset_y + camera.height;
  settings.min_exposure_us =
      std::max(1, static_cast<int>(std::floor(1e6 * camera.min_exposure.count())));
  settings.max_exposure_us = static_cast<int>(std::ceil(1e6 * camera.max_exposure.count()));
  settings.temperature_c = file.simulation.temperature_c.value_or(settings.temperature_c);
  settings.rate = options.speed;
  settings.late_frames = options.late_frames;
  settings.chunks = options.chunk_data;
  return settings;
}

// What the double's sensor sees. Called by the camera's thread only.
class Scene {
 public:
  Scene(const RigFile& file, const GigeCameraSettings& settings, const DeviceBench& bench,
        const Brdf& sample)
      : truth_(file.simulation),
        leds_(file.config.colour_channels.has_value()),
        wheel_(file.config.filter_wheel),
        axes_(file.config.axis_names().size()),
        bench_(bench),
        sample_(sample),
        imager_(file.simulation, file.built, settings.sensor_width, settings.sensor_height,
                Random(kSeed, kCameraStream)) {}

  void Expose(const GigeExposure& settings, std::vector<std::uint16_t>& counts) {
    SimView view;
    for (std::size_t i = 0; i < axes_; ++i) view.arms[i] = bench_.Angle(i);
    view.arms = view.arms + truth_.axis_offset;
    view.power = bench_.LampPower();
    view.spectrum = Spectrum();
    view.readout = {.exposure = settings.exposure,
                    .gain_db = settings.gain_db,
                    .black_level = settings.black_level,
                    .temperature_c = truth_.temperature_c,
                    .region = {settings.x, settings.y, settings.width, settings.height},
                    .layout = settings.layout,
                    .full_scale = settings.full_scale};
    counts = imager_.Expose(view, sample_).counts;
  }

 private:
  Rgb Spectrum() const {
    if (leds_) return SpectrumOf(bench_.LampColour(), truth_.colour_crosstalk);
    if (!wheel_) return Rgb::Ones();
    // The wheel is the bench's last axis.
    const double at = bench_.Angle(axes_);
    for (const LightColour colour : kLightColours) {
      const double off = at - wheel_->positions[static_cast<std::size_t>(colour)];
      if (std::abs(off) <= 2 * wheel_->limits.position_tolerance) {
        return SpectrumOf(colour, truth_.colour_crosstalk);
      }
    }
    return Rgb::Zero();
  }

  const SimConfig truth_;
  const bool leds_;
  const std::optional<FilterWheel> wheel_;
  const std::size_t axes_;
  const DeviceBench& bench_;
  const Brdf& sample_;
  SimImager imager_;
};

std::shared_ptr<std::ofstream> OpenLog(const std::filesystem::path& path) {
  if (path.empty()) return nullptr;
  auto log = std::make_shared<std::ofstream>(path);
  if (!*log) throw ConfigError(path.string() + ": cannot be written");
  return log;
}

void Log(const GigeExposure& exposure, const std::vector<std::uint16_t>& counts,
         std::ofstream& log) {
  const std::string_view bytes(reinterpret_cast<const char*>(counts.data()),
                               counts.size() * sizeof counts[0]);
  log << fmt::format("{} {:.6f}\n", Sha256(bytes), exposure.exposure.count()) << std::flush;
}

}  // namespace

std::unique_ptr<GigeCamera> ServeCamera(const RigFile& file, const DeviceBench& bench,
                                        const Brdf& sample, const CameraDoubleOptions& options) {
  const CameraDevice& device = file.config.camera_device;
  if (device.genicam.address.rfind("127.", 0) != 0) {
    throw ConfigError(device.where +
                      ": a double can be served on loopback only: address: 127.0.0.1");
  }
  const GigeCameraSettings settings = SettingsOf(file, options);
  const auto scene = std::make_shared<Scene>(file, settings, bench, sample);
  const auto log = OpenLog(options.frames_log);
  auto camera = GigeCamera::Serve(
      settings, [scene, log](const GigeExposure& exposure, std::vector<std::uint16_t>& counts) {
        scene->Expose(exposure, counts);
        if (log) Log(exposure, counts, *log);
      });
  if (!camera) throw ConfigError(device.where + ": " + camera.error().message);
  return std::move(camera).value();
}

}  // namespace gonio
