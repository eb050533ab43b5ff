// SPDX-License-Identifier: Apache-2.0
// DIR/geometry.yaml: a GeometryFit as a calibration file of kind `geometry`
// (acquisition/radiometry/calibration_file.h), and its use on a rig.

#pragma once

#include <cstdint>
#include <filesystem>

#include "acquisition/geometry_calibration/bundle.h"
#include "acquisition/radiometry/calibration_file.h"
#include "acquisition/rig.h"

namespace gonio {

inline constexpr const char* kGeometryFile = "geometry.yaml";

// Throws std::runtime_error "PATH: cannot write: REASON".
void WriteGeometry(const std::filesystem::path& path, const GeometryFit& fit,
                   const SensorFormat& camera, std::int64_t now);

// Throws ConfigError as ReadCalibration() does. The covariance is not in the file: what it is used
// for needs the uncertainties only.
GeometryFit ReadGeometry(const std::filesystem::path& path, const SensorFormat& camera,
                         std::int64_t now);

// Puts what was found in place of what the rig file believes: imaging and the axes' offsets.
void UseGeometry(const GeometryFit& fit, RigConfig& rig);

}  // namespace gonio
