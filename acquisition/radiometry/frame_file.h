// SPDX-License-Identifier: Apache-2.0
// A raw frame on disk: NAME.tiff with its counts, and beside it NAME.yaml with what else a Frame
// says, its monitor reading and the digest of the counts:
//
//   format: gonio-frame
//   version: 1
//   exposure_s: 0.25
//   gain_db: 0
//   black_level: 64
//   monitor: 0.9987
//   start_s: 12.5
//   temperature_c: 41.5      # left out if the camera does not tell
//   colour: green            # of the light; left out if it has none
//   sha256: "1f0c93aa..."    # of NAME.tiff

#pragma once

#include <filesystem>
#include <optional>

#include "acquisition/radiometry/sensor.h"
#include "drivers/light.h"

namespace gonio {

struct StoredFrame {
  Frame frame;
  double monitor = 0;  // light over light at calibration; 0: taken in the dark
  std::optional<LightColour> colour = std::nullopt;  // of the light, if it has colours
};

// `yaml` is NAME.yaml. The counts are written first, each file whole or not at all. Throws
// std::runtime_error "PATH: cannot write: ...".
void WriteFrameFile(const std::filesystem::path& yaml, const SensorFormat& format,
                    const StoredFrame& stored);

// Empty: there is none, or only a part of it. Throws ConfigError if it is no such file.
std::optional<StoredFrame> ReadFrameFile(const std::filesystem::path& yaml,
                                         const SensorFormat& format);

}  // namespace gonio
