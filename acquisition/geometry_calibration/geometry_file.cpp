// SPDX-License-Identifier: Apache-2.0
#include "acquisition/geometry_calibration/geometry_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace gonio {
namespace {

constexpr const char* kKind = "geometry";

}  // namespace

void WriteGeometry(const std::filesystem::path& path, const GeometryFit& fit,
                   const SensorFormat& camera, std::int64_t now) {
  CalibrationData data;
  data.kind = kKind;
  data.created = now;
  data.format = camera;
  const int unknowns = fit.has_light ? kGeometryUnknowns : kCameraUnknowns;
  for (int i = 0; i < unknowns; ++i) data.estimates[kGeometryNames[i]] = fit.unknowns[i];
  data.estimates["board_rms_px"] = {fit.board_rms, 0};
  data.estimates["board_views"] = {static_cast<double>(fit.board_views), 0};
  if (fit.has_light) {
    data.estimates["mirror_rms_px"] = {fit.mirror_rms, 0};
    data.estimates["mirror_views"] = {static_cast<double>(fit.mirror_views), 0};
  }
  if (!fit.left_out.empty())
    data.texts["left_out"] = fmt::format("{}", fmt::join(fit.left_out, ", "));
  WriteCalibration(path, data);
}

GeometryFit ReadGeometry(const std::filesystem::path& path, const SensorFormat& camera,
                         std::int64_t now) {
  const CalibrationData data =
      ReadCalibration(path, {.kind = kKind, .format = camera, .now = now, .temperature_c = {}});
  GeometryFit fit;
  fit.has_light = data.estimates.contains(kGeometryNames[kLightDistance]);
  const auto get = [&](const char* name) {
    const auto found = data.estimates.find(name);
    if (found == data.estimates.end()) {
      throw ConfigError(fmt::format("{}: estimates: has no {}", path.string(), name));
    }
    return found->second;
  };
  const int unknowns = fit.has_light ? kGeometryUnknowns : kCameraUnknowns;
  for (int i = 0; i < unknowns; ++i) fit.unknowns[i] = get(kGeometryNames[i]);
  fit.distorted = fit[kRadialDistortion] != 0;
  fit.board_rms = get("board_rms_px").value;
  fit.board_views = static_cast<int>(get("board_views").value);
  if (fit.has_light) {
    fit.mirror_rms = get("mirror_rms_px").value;
    fit.mirror_views = static_cast<int>(get("mirror_views").value);
  }
  return fit;
}

void UseGeometry(const GeometryFit& fit, RigConfig& rig) {
  Imaging& imaging = rig.imaging;
  imaging.focal_length = fit[kFocalLength];
  imaging.principal_x = fit[kPrincipalX];
  imaging.principal_y = fit[kPrincipalY];
  imaging.radial_distortion = fit[kRadialDistortion];
  for (int i = 0; i < 3; ++i) {
    imaging.camera_turn[i] = fit.unknowns[kCameraTurnX + i].value;
  }
  imaging.camera_distance = fit[kCameraDistance];
  rig.axis_offsets[kCameraAzimuth] = fit[kCameraAzimuthOffset];
  rig.axis_offsets[kCameraElevation] = fit[kCameraElevationOffset];
  if (fit.has_light) {
    imaging.light_distance = fit[kLightDistance];
    rig.axis_offsets[kLightAzimuth] = fit[kLightAzimuthOffset];
    rig.axis_offsets[kLightElevation] = fit[kLightElevationOffset];
  }
  rig.sigma_of_directions = fit.SigmaOfDirections({});
}

}  // namespace gonio
