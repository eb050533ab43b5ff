// SPDX-License-Identifier: Apache-2.0
// What the steps of a calibration have in common: earlier files, moving, metering, taking frames.

#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/calibration/frame_store.h"
#include "acquisition/calibration/steps.h"
#include "acquisition/frame_taker.h"
#include "acquisition/image_regions.h"
#include "acquisition/light_colours.h"
#include "acquisition/path_planner.h"
#include "brdf/direction.h"

namespace gonio {

// One step on opened devices. Whatever happens, its end finds the light off. One thread.
class StepFrames {
 public:
  // `step`: name of the command, "flat". Keeps references.
  StepFrames(const StepParts& parts, const StepOptions& options, std::string step);
  ~StepFrames();
  StepFrames(const StepFrames&) = delete;
  StepFrames& operator=(const StepFrames&) = delete;

  const SensorFormat& format() const { return format_; }
  const RigConfig& rig() const { return parts_.rig; }
  const StepOptions& options() const { return options_; }

  // The files of earlier steps. Throws ConfigError, also if one of `needed` is missing.
  Calibrations Earlier(std::vector<CalibrationKind> needed) const;

  // The pair that the options name, or the default.
  DirectionPair Pose() const;

  // Homes and lights once, moves, and notes which pixels see the sample. kRefused: out of reach.
  Result<void> GoTo(const DirectionPair& pair);
  // In which colours of the light a step takes its frames, one after the other; one turn, empty,
  // for a light without.
  std::vector<std::optional<LightColour>> Turns() const { return ColoursInTurn(parts_.rig); }
  // The one that the camera sees brightest.
  std::optional<LightColour> BrightestColour() const;
  // What is metered and taken from now on is lit in this one.
  Result<void> LightIn(const std::optional<LightColour>& colour);

  // Where the arms are, in the sample's frame: encoders and the offsets of geometry.yaml.
  const ArmAngles& arms() const { return arms_; }
  // As the camera is held there.
  const Imaging& imaging() const { return imaging_; }
  const std::vector<ImageRegion>& regions() const { return regions_; }
  // What to meter on instead. Not empty.
  void LookAt(std::vector<ImageRegion> regions) { regions_ = std::move(regions); }

  // The exposure [s] that brings the brightest channel to `fraction` of full scale on these pixels,
  // as far as the camera's range goes.
  Result<double> Meter(double fraction);

  // Takes what `choose` says, or what an earlier start had chosen, except for what that had taken.
  // `part`: distinguishes several series of a step, "" if there is one; colours are distinguished
  // anyway.
  using Choose = std::function<Result<std::vector<double>>()>;
  Result<std::vector<StoredFrame>> Take(bool lit, const std::string& part, const Choose& choose);

  // The step's files are written: its raw frames may go.
  void Finish() const;

  std::filesystem::path FileOf(CalibrationKind kind) const;
  // Of the step's frames.
  CalibrationStamp Stamp(const std::vector<StoredFrame>& frames) const;

 private:
  Result<StoredFrame> TakeOne(double exposure, bool lit);
  std::string PartOf(bool lit, const std::string& part) const;
  FrameStore::Settings Settings(bool lit) const;
  std::filesystem::path FramesFolder() const;

  const StepParts parts_;
  const StepOptions& options_;
  const std::string step_;
  const SensorFormat format_;
  FrameTaker taker_;
  ColourChanger colours_;
  std::optional<LightColour> colour_;
  const PathPlanner paths_;
  bool prepared_ = false;
  ArmAngles arms_{};
  Imaging imaging_;
  std::vector<ImageRegion> regions_;
};

// Both in the plane of incidence, from the normal: StandardPoint has the signs.
DirectionPair PairInPlane(double theta_i, double theta_o);

// exposures[i] `times` over, one after the other.
std::vector<double> Repeated(const std::vector<double>& exposures, int times);

}  // namespace gonio
