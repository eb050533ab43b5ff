// SPDX-License-Identifier: Apache-2.0
// Each product of this library as a calibration file, and back.
//
// Write...() throws std::runtime_error, Read...() ConfigError; calibration_file.h says when, and
// what a file looks like. The kinds: photon-transfer, dark, bad-pixels, flat-field, responsivity,
// stray-light. `CalibrationDemand::kind` is set by Read...().

#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "acquisition/radiometry/bad_pixels.h"
#include "acquisition/radiometry/calibration_file.h"
#include "acquisition/radiometry/dark_library.h"
#include "acquisition/radiometry/flat_field.h"
#include "acquisition/radiometry/linearity.h"
#include "acquisition/radiometry/stray_light.h"
#include "brdf/brdf.h"

namespace gonio {

// What all files say about when and with what they were taken.
struct CalibrationStamp {
  std::int64_t created = 0;  // s since 1970-01-01 UTC
  SensorFormat format;
  std::optional<double> temperature_c;
  // Identity of a light with colours. Only files that depend on the light say it: flat field,
  // responsivity, stray light.
  std::string light = {};
};

// The numbers of a photon transfer series.
struct SensorCalibration {
  MeasuredValue gain;        // electrons/count
  MeasuredValue read_noise;  // electrons
  MeasuredValue full_well;   // electrons
  // s, true minus told exposure; 0 +- 0: it was not measured, and the camera is believed.
  MeasuredValue exposure_offset{0, 0};
  Linearity linearity = Linearity::Identity(1);
};
void WriteSensor(const std::filesystem::path& path, const CalibrationStamp& stamp,
                 const SensorCalibration& sensor);
SensorCalibration ReadSensor(const std::filesystem::path& path, CalibrationDemand demand);

// Format and date are the library's own.
void WriteDark(const std::filesystem::path& path, const DarkLibrary& library);
DarkLibrary ReadDark(const std::filesystem::path& path, CalibrationDemand demand);

void WriteBadPixels(const std::filesystem::path& path, const CalibrationStamp& stamp,
                    const BadPixels& bad);
BadPixels ReadBadPixels(const std::filesystem::path& path, CalibrationDemand demand);

// The format is the flat's own.
void WriteFlatField(const std::filesystem::path& path, const CalibrationStamp& stamp,
                    const FlatField& flat);
FlatField ReadFlatField(const std::filesystem::path& path, CalibrationDemand demand);
// The same for a light with colours, whose stamp or demand names it: one for each channel.
using ColourFlats = std::array<FlatField, kChannels>;
void WriteColourFlats(const std::filesystem::path& path, const CalibrationStamp& stamp,
                      const ColourFlats& flats);
ColourFlats ReadColourFlats(const std::filesystem::path& path, CalibrationDemand demand);

struct Responsivity {
  std::string standard;                               // ReferenceStandard::name()
  std::array<MeasuredValue, kChannels> responsivity;  // electrons/s/(1/sr) at light 1
};
void WriteResponsivity(const std::filesystem::path& path, const CalibrationStamp& stamp,
                       const Responsivity& responsivity);
Responsivity ReadResponsivity(const std::filesystem::path& path, CalibrationDemand demand);

using StrayLights = std::array<StrayLight, kChannels>;
void WriteStrayLight(const std::filesystem::path& path, const CalibrationStamp& stamp,
                     const StrayLights& stray);
StrayLights ReadStrayLight(const std::filesystem::path& path, CalibrationDemand demand);

}  // namespace gonio
