// SPDX-License-Identifier: Apache-2.0
#include "acquisition/calibration/calibrations.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/file.h"
#include "core/sha256.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

constexpr double kDay = 86400;

double AgeOf(const CalibrationFile& file, std::int64_t now) {
  return static_cast<double>(now - file.created);
}

CalibrationDemand OfLight(CalibrationDemand demand, const Calibrations& calibrations) {
  demand.light = calibrations.light;
  return demand;
}

void ReadProduct(const CalibrationFile& file, const CalibrationDemand& demand,
                 Calibrations* calibrations) {
  switch (file.kind) {
    case CalibrationKind::kDark:
      calibrations->dark = ReadDark(file.path, demand);
      return;
    case CalibrationKind::kPhotonTransfer:
      calibrations->sensor = ReadSensor(file.path, demand);
      return;
    case CalibrationKind::kBadPixels:
      calibrations->bad_pixels = ReadBadPixels(file.path, demand);
      return;
    case CalibrationKind::kFlatField:
      if (calibrations->light.empty()) {
        calibrations->flat = ReadFlatField(file.path, OfLight(demand, *calibrations));
      } else {
        calibrations->colour_flats = ReadColourFlats(file.path, OfLight(demand, *calibrations));
      }
      return;
    case CalibrationKind::kStrayLight:
      calibrations->stray = ReadStrayLight(file.path, OfLight(demand, *calibrations));
      return;
    case CalibrationKind::kResponsivity:
      calibrations->responsivity = ReadResponsivity(file.path, OfLight(demand, *calibrations));
      return;
  }
}

void RefuseMissing(const CalibrationPolicy& policy) {
  if (!fs::is_directory(policy.folder)) {
    throw ConfigError(fmt::format("{}: no such folder of calibrations; {} begins one",
                                  policy.folder.string(), CommandFor(CalibrationKind::kDark)));
  }
  for (const CalibrationKind kind : policy.required) {
    if (fs::exists(policy.folder / FileNameOf(kind))) continue;
    throw ConfigError(fmt::format("{}: has no {}, which calibration.required names; {} makes it",
                                  policy.folder.string(), FileNameOf(kind), CommandFor(kind)));
  }
}

std::string TooOld(const CalibrationFile& file, const CalibrationPolicy& policy, std::int64_t now) {
  return WhyTooOld(file.path, file.created, CommandFor(file.kind), policy, now);
}

void CopyFile(const fs::path& from, const fs::path& folder, const std::string& sha256) {
  const std::string bytes = ReadTextFile(from);
  if (!sha256.empty() && Sha256(bytes) != sha256) {
    throw ConfigError(from.string() + ": was changed while the session began");
  }
  WriteFileAtomically(folder / from.filename(), [&](std::ostream& out) { out << bytes; });
}

}  // namespace

const FlatField* FlatFor(const Calibrations& calibrations,
                         const std::optional<LightColour>& colour) {
  if (colour && calibrations.colour_flats) {
    return &(*calibrations.colour_flats)[static_cast<std::size_t>(*colour)];
  }
  return !colour && calibrations.flat ? &*calibrations.flat : nullptr;
}

Calibrations LoadCalibrations(const CalibrationPolicy& policy, const SensorFormat& format,
                              std::int64_t now, const std::string& light) {
  RefuseMissing(policy);
  Calibrations calibrations;
  calibrations.format = format;
  calibrations.light = light;
  CalibrationDemand demand;
  demand.format = format;
  demand.now = now;
  for (const CalibrationKind kind : kCalibrationKinds) {
    CalibrationFile file{kind, policy.folder / FileNameOf(kind), "", 0, {}};
    if (!fs::exists(file.path)) continue;
    file.sha256 = Sha256OfFile(file.path);
    const CalibrationHeader header = ReadCalibrationHeader(file.path);
    file.created = header.created;
    for (const std::string& image : header.image_files)
      file.images.push_back(policy.folder / image);
    ReadProduct(file, demand, &calibrations);
    const std::string old = TooOld(file, policy, now);
    if (policy.refuse_old && !old.empty()) throw ConfigError(old);
    calibrations.files.push_back(std::move(file));
  }
  return calibrations;
}

std::string WhyTooOld(const std::filesystem::path& file, std::int64_t created,
                      const std::string& command, const CalibrationPolicy& policy,
                      std::int64_t now) {
  const auto age = static_cast<double>(now - created);
  if (age <= policy.max_age) return {};
  return fmt::format("{}: is {:.1f} days old, calibration.max_age_days is {:.1f}; {} renews it",
                     file.string(), age / kDay, policy.max_age / kDay, command);
}

std::string AgesOf(const Calibrations& calibrations, std::int64_t now) {
  std::vector<std::string> ages;
  for (const CalibrationFile& file : calibrations.files) {
    ages.push_back(fmt::format("{} {:.1f} days", ToString(file.kind), AgeOf(file, now) / kDay));
  }
  return ages.empty() ? "none" : fmt::format("{}", fmt::join(ages, ", "));
}

std::vector<std::string> OldOnes(const Calibrations& calibrations, const CalibrationPolicy& policy,
                                 std::int64_t now) {
  std::vector<std::string> old;
  for (const CalibrationFile& file : calibrations.files) {
    if (std::string why = TooOld(file, policy, now); !why.empty()) old.push_back(std::move(why));
  }
  return old;
}

void CopyCalibrations(const Calibrations& calibrations, const std::filesystem::path& folder) {
  fs::create_directories(folder);
  for (const CalibrationFile& file : calibrations.files) {
    // Images first: whoever finds the YAML finds what it names. Their digests stand in it.
    for (const fs::path& image : file.images) CopyFile(image, folder, "");
    CopyFile(file.path, folder, file.sha256);
  }
}

Calibrations LoadCopies(const std::filesystem::path& folder) {
  CalibrationPolicy policy;
  policy.folder = folder;
  policy.max_age = std::numeric_limits<double>::infinity();
  std::optional<SensorFormat> format;
  std::string light;
  std::int64_t newest = 0;
  for (const CalibrationKind kind : kCalibrationKinds) {
    const fs::path path = folder / FileNameOf(kind);
    if (!fs::exists(path)) continue;
    const CalibrationHeader header = ReadCalibrationHeader(path);
    if (!format) format = header.format;
    if (!header.light.empty()) light = header.light;
    newest = std::max(newest, header.created);
  }
  return format ? LoadCalibrations(policy, *format, newest, light) : Calibrations{};
}

}  // namespace gonio
