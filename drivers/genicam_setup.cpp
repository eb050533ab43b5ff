// SPDX-License-Identifier: Apache-2.0
#include "drivers/genicam_setup.h"

#include <arv.h>
#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <string_view>
#include <utility>

namespace gonio {
namespace {

constexpr double kGainTolerance = 0.05;  // dB, of rounding to the camera's steps
constexpr double kBlackTolerance = 0.5;  // counts, of the same
constexpr double kMicrosecond = 1e-6;

Error Refused(std::string message) { return {ErrorCode::kRefused, std::move(message)}; }

class Setup {
 public:
  Setup(const GenicamSettings& settings, ArvCamera* camera, GenicamFeatures& features)
      : settings_(settings), camera_(camera), features_(features) {}

  Result<void> Configure();
  const GenicamSetup& made() const { return made_; }

 private:
  Result<void> ConfigureFormat();
  Result<void> ConfigureRegion();
  Result<void> ConfigureGain();
  Result<void> ConfigureBlackLevel();
  Result<void> ConfigureExposure();
  Result<void> ConfigureTrigger();
  Result<void> ConfigureChunks();
  Result<bool> EnableChunk(const char* chunk);
  Result<void> Identify();

  const GenicamSettings& settings_;
  ArvCamera* const camera_;
  GenicamFeatures& features_;
  GenicamSetup made_;
};

Result<void> Setup::Configure() {
  using Step = Result<void> (Setup::*)();
  for (const Step step : {&Setup::ConfigureFormat, &Setup::ConfigureRegion, &Setup::ConfigureGain,
                          &Setup::ConfigureBlackLevel, &Setup::ConfigureExposure,
                          &Setup::ConfigureTrigger, &Setup::ConfigureChunks, &Setup::Identify}) {
    if (const auto done = (this->*step)(); !done) return done;
  }
  return {};
}

Result<void> Setup::ConfigureFormat() {
  made_.format = FindPixelFormat(settings_.pixel_format);
  if (!made_.format)
    return Refused(fmt::format("pixel format {} is not known", settings_.pixel_format));
  GError* error = nullptr;
  guint count = 0;
  gint64* codes = arv_camera_dup_available_pixel_formats(camera_, &count, &error);
  if (error) return GenicamError(error, "PixelFormat");
  // By code: the names of old cameras differ.
  std::string others;
  bool found = false;
  for (guint i = 0; i < count; ++i) {
    if (codes[i] == made_.format->code) found = true;
    for (const PixelFormat& known : KnownPixelFormats()) {
      if (codes[i] == known.code) others += (others.empty() ? "" : ", ") + known.name;
    }
  }
  g_free(codes);
  if (!found) {
    return Refused(fmt::format("PixelFormat: wanted {}, but the camera has {}", made_.format->name,
                               others.empty() ? "none that is known" : others));
  }
  arv_camera_set_pixel_format(camera_, made_.format->code, &error);
  if (error) return GenicamError(error, "PixelFormat = " + made_.format->name);
  const ArvPixelFormat got = arv_camera_get_pixel_format(camera_, &error);
  if (error) return GenicamError(error, "PixelFormat");
  if (got == made_.format->code) return {};
  return Refused(fmt::format("PixelFormat: wanted {}, got code 0x{:08X}", made_.format->name, got));
}

Result<void> Setup::ConfigureRegion() {
  // Offsets first go to 0, where every size fits.
  for (const auto& [feature, value] :
       std::initializer_list<std::pair<const char*, int>>{{"OffsetX", 0},
                                                          {"OffsetY", 0},
                                                          {"Width", settings_.width},
                                                          {"Height", settings_.height},
                                                          {"OffsetX", settings_.offset_x},
                                                          {"OffsetY", settings_.offset_y}}) {
    if (value == 0 && !features_.Has(feature)) continue;
    if (const auto set = features_.SetNumber(feature, value); !set) return set;
  }
  // A few cameras let the region hang over the edge of the sensor.
  for (const auto& [feature, end] : {std::pair{"SensorWidth", settings_.offset_x + settings_.width},
                                     {"SensorHeight", settings_.offset_y + settings_.height}}) {
    if (!features_.Has(feature)) continue;
    const auto size = features_.Number(feature);
    if (!size) return size.error();
    if (end > *size) {
      return Refused(
          fmt::format("the region ends at {} px, beyond the {} of {:.0f} px", end, feature, *size));
    }
  }
  made_.info.width = settings_.width;
  made_.info.height = settings_.height;
  made_.info.layout = made_.format->layout;
  made_.info.full_scale = made_.format->full_scale();
  return {};
}

Result<void> Setup::ConfigureGain() {
  if (const auto set = features_.SetTextIfThere("GainAuto", "Off"); !set) return set;
  const std::string feature = features_.FirstOf({"Gain", "GainRaw", "GainAbs"});
  if (feature.empty()) {
    return settings_.gain_db == 0 ? Result<void>() : Refused("Gain: the camera has none");
  }
  const bool raw = feature == "GainRaw";
  if (raw && !(settings_.gain_raw_step_db > 0)) {
    return Refused(
        "GainRaw: the camera's gain is in steps, and gain_raw_step_db does not say of "
        "how many dB");
  }
  const double unit = raw ? settings_.gain_raw_step_db : 1;
  const double tolerance = raw ? 1 : kGainTolerance;
  if (const auto set = features_.SetNumber(feature, settings_.gain_db / unit, tolerance); !set) {
    return set;
  }
  const auto got = features_.Number(feature);
  if (!got) return got.error();
  made_.gain_db = *got * unit;
  return {};
}

Result<void> Setup::ConfigureBlackLevel() {
  if (const auto set = features_.SetTextIfThere("BlackLevelAuto", "Off"); !set) return set;
  const std::string feature = features_.FirstOf({"BlackLevel", "BlackLevelRaw", "BlackLevelAbs"});
  if (settings_.black_level) {
    if (feature.empty()) return Refused("BlackLevel: the camera has none");
    const auto set = features_.SetNumber(feature, *settings_.black_level, kBlackTolerance);
    if (!set) return set;
  }
  if (feature.empty()) return {};
  const auto got = features_.Number(feature);
  if (!got) return got.error();
  made_.black_level = *got;
  return {};
}

Result<void> Setup::ConfigureExposure() {
  for (const auto& [feature, value] :
       {std::pair{"ExposureMode", "Timed"}, {"ExposureAuto", "Off"}}) {
    if (const auto set = features_.SetTextIfThere(feature, value); !set) return set;
  }
  made_.exposure_feature =
      features_.FirstOf({"ExposureTime", "ExposureTimeAbs", "ExposureTimeRaw"});
  if (made_.exposure_feature.empty()) return Refused("ExposureTime: the camera has none");
  const auto bounds = features_.Bounds(made_.exposure_feature);
  if (!bounds) return bounds.error();
  made_.info.min_exposure = Seconds(kMicrosecond * std::max(bounds->min, 0.01));
  made_.info.max_exposure = Seconds(kMicrosecond * bounds->max);
  made_.temperature_feature = features_.FirstOf({"DeviceTemperature", "TemperatureAbs"});
  made_.info.readout = settings_.readout;
  if (features_.Has("SensorReadoutTime")) {
    const auto readout = features_.Number("SensorReadoutTime");
    if (!readout) return readout.error();
    made_.info.readout = Seconds(kMicrosecond * *readout);
  }
  return {};
}

Result<void> Setup::ConfigureTrigger() {
  const std::string& line = settings_.trigger_line;
  if (const auto set = features_.SetText("AcquisitionMode", "Continuous"); !set) return set;
  if (const auto set = features_.SetTextIfThere("TriggerSelector", "FrameStart"); !set) return set;
  if (const auto set = features_.SetText("TriggerMode", "On"); !set) return set;
  const auto source = features_.SetText("TriggerSource", line.empty() ? "Software" : line);
  if (!source) return source;
  if (line.empty()) return {};
  return features_.SetTextIfThere("TriggerActivation", "RisingEdge");
}

Result<void> Setup::ConfigureChunks() {
  if (!features_.Has("ChunkModeActive")) return {};
  const bool wanted = settings_.chunk_data && features_.Has("ChunkSelector");
  GError* error = nullptr;
  arv_camera_set_chunk_mode(camera_, wanted, &error);
  if (error) return GenicamError(error, "ChunkModeActive");
  if (!wanted) return {};
  const auto exposure = EnableChunk("ExposureTime");
  if (!exposure) return exposure.error();
  made_.tells_exposure = *exposure;
  // Old cameras have their gain in steps, and their frames, too.
  if (features_.Has("Gain")) {
    const auto gain = EnableChunk("Gain");
    if (!gain) return gain.error();
    made_.tells_gain = *gain;
  }
  if (made_.tells_exposure || made_.tells_gain) return {};
  arv_camera_set_chunk_mode(camera_, false, &error);
  if (error) return GenicamError(error, "ChunkModeActive");
  return {};
}

Result<bool> Setup::EnableChunk(const char* chunk) {
  ArvDevice* device = arv_camera_get_device(camera_);
  GError* error = nullptr;
  guint count = 0;
  const char** names = arv_device_dup_available_enumeration_feature_values_as_strings(
      device, "ChunkSelector", &count, &error);
  const bool known =
      std::any_of(names, names + count, [&](std::string_view name) { return name == chunk; });
  g_free(names);
  if (error) return GenicamError(error, "ChunkSelector");
  if (!known) return false;
  arv_camera_set_chunk_state(camera_, chunk, true, &error);
  const bool enabled = !error && arv_camera_get_chunk_state(camera_, chunk, &error);
  if (error) return GenicamError(error, fmt::format("ChunkEnable of {}", chunk));
  return enabled;
}

Result<void> Setup::Identify() {
  for (const auto& feature :
       {features_.FirstOf({"DeviceVendorName"}), features_.FirstOf({"DeviceModelName"}),
        features_.FirstOf({"DeviceSerialNumber", "DeviceID"}),
        features_.FirstOf({"DeviceFirmwareVersion", "DeviceVersion"})}) {
    if (feature.empty()) continue;
    const auto text = features_.Text(feature);
    if (!text) return text.error();
    if (!made_.identity.empty()) made_.identity += ", ";
    if (feature.starts_with("DeviceSer") || feature == "DeviceID") made_.identity += "serial ";
    if (feature.ends_with("Version")) made_.identity += "firmware ";
    made_.identity += *text;
  }
  made_.identity +=
      fmt::format(", {}, {} x {} px at {}, {}, gain {:.4g} dB, black level {:.4g}, trigger {}",
                  made_.format->name, settings_.width, settings_.height, settings_.offset_x,
                  settings_.offset_y, made_.gain_db, made_.black_level,
                  settings_.trigger_line.empty() ? "Software" : settings_.trigger_line);
  if (made_.tells_exposure) made_.identity += ", frames say their exposure";
  return {};
}

}  // namespace

Result<GenicamSetup> MakeSettings(const GenicamSettings& settings, ArvCamera* camera,
                                  GenicamFeatures& features) {
  Setup setup(settings, camera, features);
  if (const auto made = setup.Configure(); !made) return made.error();
  return setup.made();
}

}  // namespace gonio
