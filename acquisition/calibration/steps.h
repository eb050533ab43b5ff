// SPDX-License-Identifier: Apache-2.0
// The steps of a calibration, each a procedure on opened devices that ends with files in a folder.
//
//   darks            light off                  dark.yaml, bad-pixels.yaml
//   photon transfer  white tile, many exposures photon-transfer.yaml     needs darks
//   flat             white tile                 flat-field.yaml, bad-pixels.yaml   and that
//   stray light      black trap                 stray-light.yaml         and that
//   glare            white tile with a trap     stray-light.yaml         and that, stray light
//   standard         reference standard         responsivity.yaml        and that; stray light if
//                                                                         there is any
//
// What is mounted is the user's word. docs/radiometry.md says what goes into which file. Steps that
// need an earlier one's file throw ConfigError naming the command that makes it.
//
// Raw frames are kept in FOLDER/STEP.frames/ until the file is written: a step that was stopped,
// killed or failed goes on with them when it is started again with the same settings.

#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "acquisition/calibration/calibrations.h"
#include "acquisition/rig.h"

namespace gonio {

struct StepParts {
  const RigConfig& rig;
  Devices& devices;
  Clock& clock;
};

struct StepOptions {
  std::filesystem::path folder;  // made if it is not there
  // Where the arms go, rad from the normal: both in one plane, the camera on the side of the
  // mirror direction if theta_o > 0. Empty: light at 45 degrees, camera at the normal; of a
  // standard, every point of its certificate.
  std::optional<double> theta_i;
  std::optional<double> theta_o;
  int frames = 0;      // of each exposure; 0: what the step thinks right
  bool again = false;  // forget frames of an earlier start
  bool keep_frames = false;
  double trap_radius = 0;          // m, of the trap in the tile; 0: Imaging::patch_radius
  std::filesystem::path standard;  // the reference standard's file
  std::int64_t now = 0;            // s since 1970-01-01 UTC
  std::stop_token stop;            // after the frame in hand; kCancelled
  std::function<void(int done, int total, const std::string& what)> progress;
};

// What a step found, for people.
struct StepReport {
  std::vector<std::string> lines;
  std::vector<std::filesystem::path> files;
};

// Errors are those of the devices, kRefused where the frames do not allow the result. Each leaves
// the light off.
Result<StepReport> CalibrateDarks(const StepParts& parts, const StepOptions& options);
Result<StepReport> CalibratePhotonTransfer(const StepParts& parts, const StepOptions& options);
Result<StepReport> CalibrateFlat(const StepParts& parts, const StepOptions& options);
Result<StepReport> CalibrateStrayLight(const StepParts& parts, const StepOptions& options);
// kRefused also where the trap is not black, or nothing is seen of it. Throws ConfigError for a rig
// without `imaging`, whose pixels all see the same.
Result<StepReport> CalibrateGlare(const StepParts& parts, const StepOptions& options);
Result<StepReport> CalibrateStandard(const StepParts& parts, const StepOptions& options);

}  // namespace gonio
