// SPDX-License-Identifier: Apache-2.0
// From a rig file to opened devices. The one place that chooses between kinds of rigs.

#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "acquisition/failure_policy.h"
#include "acquisition/interlocks.h"
#include "acquisition/radiometry/sensor.h"
#include "acquisition/rig.h"
#include "brdf/brdf.h"
#include "core/clock.h"
#include "drivers/axis_opener.h"
#include "drivers/genicam_camera.h"
#include "drivers/link_log.h"
#include "planner/candidates.h"
#include "planner/plan.h"
#include "sim/sim_config.h"

namespace gonio {

struct RigFile {
  RigConfig config;
  SimConfig simulation;  // of the parts that are not real
  InterlocksConfig interlocks;
  std::string calibrated_camera;  // the identity in geometry.yaml; empty: not used
  Imaging built;                  // as the rig file has it, which simulated parts are built by
};

// Whether what stands in the rig's calibration folder takes the place of what its file believes.
enum class CalibrationUse { kUsed, kIgnored };

// geometry.yaml and time.yaml are used where `calibration.folder` (of a relative path: beside the
// rig file) has them. Throws ConfigError naming file, line and key.
RigFile LoadRig(const std::filesystem::path& path, CalibrationUse use = CalibrationUse::kUsed,
                const std::filesystem::path& folder = {});
// The same of a text that was read from `path`, or was once.
RigFile ParseRig(const std::string& text, const std::filesystem::path& path, CalibrationUse use,
                 const std::filesystem::path& folder = {});

// Devices with the clock they live by. Destroying it stops the axes and switches the light off.
struct OpenedRig {
  std::unique_ptr<WatchedClock> clock;  // virtual on a simulated rig
  std::shared_ptr<LinkLog> wires;       // of the real devices; null on a simulated rig
  Devices devices;
  std::map<std::string, std::string> identities;  // of the devices, as they were opened first
  // SimDevices::draw, of what is simulated; empty: nothing is.
  std::function<void(std::uint64_t)> draw;
  const GenicamCamera* genicam = nullptr;  // devices.camera, if it is one
};

// A simulated rig with the limits, speeds and noise of this one, be it real or not. It looks at
// `sample`, which must outlive it; `seed` is that of its noise.
// Its clock begins at `begin`.
OpenedRig OpenSimulated(const RigFile& file, const Brdf& sample, std::uint64_t seed,
                        Seconds begin = Seconds(0));

// The real devices of a rig of kind `real`, which live by `clock`; a camera that is not looks at
// `sample`, as above, and only then is there need of one. Opens everything or nothing, and moves
// nothing.
//
// Throws ConfigError naming the place in the file if a device is not there, is not what the file
// says, or cannot do it; DeviceError, with the last lines of the wires, if one does not answer.
OpenedRig OpenReal(const RigFile& file, const Brdf* sample, std::uint64_t seed,
                   std::unique_ptr<Clock> clock);

// Closes the axes of a real rig, or its camera, light and monitor, and opens them anew, which have
// to be the same devices. Where that fails some of them are null. Nothing is ever lost of a
// simulated rig. `file` and `sample` as in OpenReal().
Result<void> Reopen(const RigFile& file, const Brdf* sample, std::uint64_t seed,
                    FailureClass failure, OpenedRig& rig);

// Who the devices say they are, by their roles; those that are open.
std::map<std::string, std::string> IdentitiesOf(const Devices& devices);

// One axis of it, as OpenReal() opens them, on a line that others may share.
Result<std::unique_ptr<Axis>> OpenRealAxis(const RigConfig& config, int axis, AxisOpener& opener);

// Has a plan choose from what a rig of this kind can reach at all.
void FitToRig(const RigConfig& rig, Plan& plan);

// The poses a plan may choose from: those the rig can reach, by ways that touch nothing, and where
// the simulated `sample`, which must outlive the result, has a reflectance: measured materials end
// somewhere, and beyond it the simulated camera refuses to expose. nullptr: the sample is real.
Reachable MeasurablePoses(const RigConfig& rig, const Brdf* sample);

}  // namespace gonio
