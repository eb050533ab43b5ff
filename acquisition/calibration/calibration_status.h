// SPDX-License-Identifier: Apache-2.0
// What a folder of calibrations holds, told without the camera.

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/calibration_kind.h"
#include "acquisition/radiometry/calibration_file.h"

namespace gonio {

struct CalibrationStatus {
  CalibrationKind kind = CalibrationKind::kDark;
  std::optional<CalibrationHeader> header;  // empty: there is no such file, or it is damaged
  std::string problem;                      // why it cannot be used; empty: nothing is known
  bool old = false;                         // older than the policy likes
  std::string numbers;                      // its main results
};

// One of each kind, in the order of kCalibrationKinds.
std::vector<CalibrationStatus> StatusOf(const CalibrationPolicy& policy, std::int64_t now);

}  // namespace gonio
