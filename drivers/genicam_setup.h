// SPDX-License-Identifier: Apache-2.0
// The settings of a GenICam camera: written, read back, and compared.

#pragma once

#include <string>

#include "drivers/genicam_camera.h"
#include "drivers/genicam_features.h"
#include "drivers/pixel_unpacking.h"

typedef struct _ArvCamera ArvCamera;

namespace gonio {

// What the camera made of its settings.
struct GenicamSetup {
  const PixelFormat* format = nullptr;
  CameraInfo info;
  std::string identity;
  double gain_db = 0;
  double black_level = 0;           // 0 if the camera has none
  std::string exposure_feature;     // in us
  std::string temperature_feature;  // in deg C; empty: it does not tell
  bool tells_exposure = false;      // each frame, in chunk data
  bool tells_gain = false;          // and in dB
};

// While nothing is acquired. kRefused names the feature, what was wanted and what was got.
Result<GenicamSetup> MakeSettings(const GenicamSettings& settings, ArvCamera* camera,
                                  GenicamFeatures& features);

}  // namespace gonio
