// SPDX-License-Identifier: Apache-2.0
// The raw frames of a calibration step that runs, so that one that was stopped can go on.
//
// DIR/settings.yaml has what the frames were taken with, and DIR/frame-0001.yaml, ... are they
// (radiometry/frame_file.h). Files are whole or not there: a killed step loses the frame in hand.

#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/radiometry/frame_file.h"

namespace gonio {

class FrameStore {
 public:
  // What decides whether old frames may be used: name -> text of one line.
  using Settings = std::map<std::string, std::string>;

  // Opens DIR or makes it. `again`: throws old frames away. Throws ConfigError "DIR: holds frames
  // of other settings: KEY is ..., was ...; --again starts over" or std::runtime_error.
  FrameStore(std::filesystem::path dir, SensorFormat format, const Settings& settings, bool again);

  // The exposures [s] to take, in order: as they were fixed at the first start, for what chose them
  // had noise. Empty: not yet.
  const std::vector<double>& exposures() const { return exposures_; }
  void FixExposures(std::vector<double> exposures);

  // Frame `index` of exposures(), if it was taken.
  std::optional<StoredFrame> Read(std::size_t index) const;
  void Write(std::size_t index, const StoredFrame& frame);

 private:
  std::filesystem::path FileOf(std::size_t index) const;
  void WriteSettings() const;

  const std::filesystem::path dir_;
  const SensorFormat format_;
  const Settings settings_;
  std::vector<double> exposures_;
};

}  // namespace gonio
