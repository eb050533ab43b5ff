// SPDX-License-Identifier: Apache-2.0
// Which calibrations there are, and which of them a rig wants.

#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/config.h"

namespace gonio {

// One file each in the folder of a rig's calibrations, named after its kind: "flat-field.yaml".
// docs/radiometry.md says what each is for.
enum class CalibrationKind {
  kDark,
  kPhotonTransfer,
  kBadPixels,
  kFlatField,
  kStrayLight,
  kResponsivity,
};
inline constexpr CalibrationKind kCalibrationKinds[] = {
    CalibrationKind::kDark,      CalibrationKind::kPhotonTransfer, CalibrationKind::kBadPixels,
    CalibrationKind::kFlatField, CalibrationKind::kStrayLight,     CalibrationKind::kResponsivity};

// "dark", "photon-transfer", ...: as in the files themselves.
const char* ToString(CalibrationKind kind);
// "dark.yaml"
std::string FileNameOf(CalibrationKind kind);
// The command that makes it: "gonio calibrate darks".
std::string CommandFor(CalibrationKind kind);

// The `calibration` mapping of a rig file.
struct CalibrationPolicy {
  std::filesystem::path folder;   // empty: none
  double max_age = 30 * 86400.0;  // s
  bool refuse_old = false;        // otherwise an old one is used, and this is said
  std::vector<CalibrationKind> required;
};
// Relative folders are beside the file that `node` is of. Throws ConfigError.
CalibrationPolicy ReadCalibrationPolicy(const ConfigNode& node);

}  // namespace gonio
