// SPDX-License-Identifier: Apache-2.0
// All that is known of one instrument by calibration, from the files of one folder.
//
// Every part may be missing; what stands in for it is said where it is used
// (acquisition/radiometry.h).

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/calibration_kind.h"
#include "acquisition/radiometry/calibration_products.h"
#include "drivers/light.h"

namespace gonio {

// A file that was read.
struct CalibrationFile {
  CalibrationKind kind = CalibrationKind::kDark;
  std::filesystem::path path;
  std::string sha256;                         // of the YAML, which names its images by theirs
  std::int64_t created = 0;                   // s since 1970-01-01 UTC
  std::vector<std::filesystem::path> images;  // that it names, beside it
};

struct Calibrations {
  SensorFormat format;  // of the camera they were checked against
  std::string light;    // identity of a light with colours, likewise; empty: it has none
  std::optional<DarkLibrary> dark;
  std::optional<SensorCalibration> sensor;
  std::optional<BadPixels> bad_pixels;
  std::optional<FlatField> flat;
  std::optional<ColourFlats> colour_flats;  // in its place, of a light with colours
  std::optional<StrayLights> stray;
  std::optional<Responsivity> responsivity;
  std::vector<CalibrationFile> files;  // in the order of kCalibrationKinds

  bool empty() const { return files.empty(); }
};

// The flat field for frames in this colour of the light, or without; nullptr: there is none.
const FlatField* FlatFor(const Calibrations& calibrations,
                         const std::optional<LightColour>& colour);

// Reads what the folder has, for the camera of `format`, at `now` [s since 1970-01-01 UTC].
// `light`: identity of a light with colours. Flat fields, responsivities and stray light are of the
// light, too; darks, photon transfers and bad pixels of the camera alone. Throws ConfigError "FILE:
// ...": no such folder; one that is required is missing (and which command makes it); another
// camera, region, layout, full scale, gain or light; damaged or of another version; from the
// future; too old, if the policy refuses that.
Calibrations LoadCalibrations(const CalibrationPolicy& policy, const SensorFormat& format,
                              std::int64_t now, const std::string& light = {});

// "dark 2.0 days, flat-field 3.1 days": how old each is at `now`; "none".
std::string AgesOf(const Calibrations& calibrations, std::int64_t now);
// "FILE: is 41.0 days old, calibration.max_age_days is 30.0; COMMAND renews it"; empty: it is not.
std::string WhyTooOld(const std::filesystem::path& file, std::int64_t created,
                      const std::string& command, const CalibrationPolicy& policy,
                      std::int64_t now);
// That for each that is older than the policy likes.
std::vector<std::string> OldOnes(const Calibrations& calibrations, const CalibrationPolicy& policy,
                                 std::int64_t now);

// Copies every file and its images into `folder`, which is made. What was read and what is copied
// must be the same bytes. Throws std::runtime_error or ConfigError.
void CopyCalibrations(const Calibrations& calibrations, const std::filesystem::path& folder);

// What a session was reduced with, from the copies in it: of whatever camera and age they are. An
// empty folder, or none, gives none. Throws ConfigError as LoadCalibrations().
Calibrations LoadCopies(const std::filesystem::path& folder);

}  // namespace gonio
