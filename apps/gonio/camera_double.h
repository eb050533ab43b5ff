// SPDX-License-Identifier: Apache-2.0
// A camera on loopback that sees what the doubles of a rig's arms and light do to a sample.

#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "apps/gonio/build_rig.h"
#include "brdf/brdf.h"
#include "sim/device_bench.h"
#include "sim/gige_camera.h"

namespace gonio {

struct CameraDoubleOptions {
  double speed = 1;                  // of the bench
  int late_frames = 0;               // as GigeCameraSettings
  bool chunk_data = false;           // whether its frames say how they were taken
  std::filesystem::path frames_log;  // a line per exposure: SHA-256 of its counts, seconds; or none
};

// Serves a double of the rig's GenICam camera at its address until it is destroyed. It sees
// `sample` from where the mechanisms of `bench` stand, under the light that is on, through the lens
// and sensor of the file's `imaging` and `simulation`. `bench` and `sample` must outlive it.
//
// Throws ConfigError if the file names no address on loopback, or it is in use, or the log cannot
// be written.
std::unique_ptr<GigeCamera> ServeCamera(const RigFile& file, const DeviceBench& bench,
                                        const Brdf& sample, const CameraDoubleOptions& options);

}  // namespace gonio
