// SPDX-License-Identifier: Apache-2.0
// What a calibration found, in a dated file that cannot be used with the wrong camera.
//
// NAME.yaml holds numbers, and beside it lie images as TIFF of 32-bit floats, one number per site
// (three channels for RGB cameras), each named with its digest:
//
//   format: gonio-calibration
//   version: 1
//   kind: flat-field
//   created_utc: "2024-05-03T09:12:44Z"
//   camera: "Vendor Model 1234"       # Camera::identity()
//   region: [0, 0, 640, 480]          # left, top, width, height, pixels
//   pixel_layout: bayer-rg
//   full_scale: 4095
//   gain_db: 0
//   temperature_c: 41.5               # of the sensor; left out if the camera does not tell
//   light: "simulated, ..."           # Light::identity() of a light with colours, in files that
//                                     # depend on it; left out otherwise
//   texts: {standard: "tile 17"}
//   estimates:                        # value and standard uncertainty; units in the names
//     gain_e_per_count: [2.02, 0.011]
//   lists:
//     dark0_exposures_s: [0.01, 1]
//   images:
//     response: {file: flat.response-1f0c93aa.tiff, sha256: "1f0c93aa..."}
//
// The images are written first and the YAML file last, each whole or not at all, so that a crash
// leaves the previous calibration in force. Images of an older one are left lying.

#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/radiometry/measured_value.h"
#include "acquisition/radiometry/sensor.h"

namespace gonio {

struct CalibrationData {
  std::string kind;
  std::int64_t created = 0;  // s since 1970-01-01 UTC
  SensorFormat format;
  std::optional<double> temperature_c;
  std::string light;  // identity of a light with colours; empty: a light without, or any
  std::map<std::string, std::string> texts;
  std::map<std::string, MeasuredValue> estimates;
  std::map<std::string, std::vector<double>> lists;  // not empty
  std::map<std::string, SiteImage> images;           // of format.sites()
};

// Throws std::runtime_error "PATH: cannot write: REASON". Numbers outside images must be finite.
void WriteCalibration(const std::filesystem::path& path, const CalibrationData& data);

// What the reader needs the calibration to be.
struct CalibrationDemand {
  std::string kind;
  SensorFormat format;                                       // of the camera as it is now
  std::int64_t now = 0;                                      // s since 1970
  double max_age = std::numeric_limits<double>::infinity();  // s
  std::optional<std::string> light = std::nullopt;  // as in CalibrationData; empty: whatever
  // Both must tell a temperature for it to be compared.
  std::optional<double> temperature_c;
  double max_temperature_difference = std::numeric_limits<double>::infinity();  // K
};

// Throws ConfigError "PATH:LINE: KEY: ..." or "PATH: ...": another kind, camera, region, layout,
// full scale, gain or light; too old or from the future; too warm or cold; an image that is
// missing, was changed, or is of another size; anything unknown.
CalibrationData ReadCalibration(const std::filesystem::path& path, const CalibrationDemand& demand);

// What can be said of a file without a camera to compare it with, and without its images.
struct CalibrationHeader {
  std::string kind;
  std::int64_t created = 0;  // s since 1970-01-01 UTC
  SensorFormat format;
  std::optional<double> temperature_c;
  std::string light;
  std::vector<std::string> image_files;  // names, beside the file
};
// Throws ConfigError as above, but judges neither kind, camera, age nor images.
CalibrationHeader ReadCalibrationHeader(const std::filesystem::path& path);

}  // namespace gonio
