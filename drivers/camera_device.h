// SPDX-License-Identifier: Apache-2.0
// Which camera a rig has, and how it is reached.

#pragma once

#include <memory>
#include <string>

#include "core/config.h"
#include "drivers/camera.h"
#include "drivers/genicam_camera.h"

namespace gonio {

struct CameraDevice {
  enum class Driver { kSimulated, kGenicam };
  std::string where;  // in the rig file: "rig.yaml:60: camera.device"
  Driver driver = Driver::kSimulated;
  GenicamSettings genicam;  // but for the name and the region's size
};

// Reads the `device` mapping of `camera` in a rig file; docs/rig-files.md lists its keys. Throws
// ConfigError.
CameraDevice ReadCameraDevice(const ConfigNode& node);

// Opens a camera that is not simulated, to read out a region of so many pixels. Errors name it by
// `name`. `clock` must outlive it. kRefused: not there, not what the file says, or it cannot do it.
Result<std::unique_ptr<Camera>> OpenCamera(const CameraDevice& device, const std::string& name,
                                           int width, int height, Clock& clock);

}  // namespace gonio
