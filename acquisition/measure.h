// SPDX-License-Identifier: Apache-2.0
// One pose: move, settle, expose until usable, reduce.

#pragma once

#include <array>
#include <functional>
#include <optional>
#include <stop_token>
#include <vector>

#include "acquisition/exposure.h"
#include "acquisition/frame_taker.h"
#include "acquisition/image_regions.h"
#include "acquisition/light_colours.h"
#include "acquisition/motion.h"
#include "acquisition/path_planner.h"
#include "acquisition/rig.h"

namespace gonio {

// Everything the devices said about one pose: what the event log keeps, before any reduction.
struct PoseRecord {
  AxisPositions commanded{};
  AxisPositions readback{};  // encoders, after settling
  int move_retries = 0;
  Seconds start{0};                  // session clock
  Seconds move_time{0};              // until the last axis was still
  Seconds end{0};                    // after the last exposure
  std::vector<ImageRegion> regions;  // by the read-back, not empty
  std::vector<Exposure> exposures;
};

// What the next pose depends on beside where the encoders say the arms are.
struct MeasurerState {
  // What each axis was last told: one that is near enough to its target is told nothing.
  AxisPositions told{};
  // That suited the last pose: the first one of the next where nothing is expected.
  std::optional<Seconds> exposure;
  // The same of a light with colours, by channel: counts per second and pixel of the last pose. And
  // the colour that its last frame was lit in.
  std::array<std::optional<double>, kChannels> rates{};
  std::optional<LightColour> colour = std::nullopt;
};

// The sample in the image while the encoders read so, without pixels that are bad.
std::vector<ImageRegion> RegionsSeen(const RigConfig& rig, const Kinematics& kinematics,
                                     const AxisPositions& readback, const SiteMask* bad);

// Measures poses with opened devices. One thread.
class PoseMeasurer {
 public:
  // Keeps references; all must outlive it. `bad`: pixels that do not measure (BadPixels::mask) are
  // no part of the regions; nullptr: all do.
  PoseMeasurer(const RigConfig& rig, Devices& devices, Clock& clock, const SiteMask* bad = nullptr);

  // Homes every axis and switches the light on; of one with colours a wheel is homed, too. Must
  // succeed once before Measure().
  Result<void> Prepare(std::stop_token stop);
  // Switches the light on, in its first colour; the axes are as they were.
  Result<void> SwitchOn(std::stop_token stop);

  // `expected`: f_r to choose the first exposure with; without it the last pose's is used.
  // kRefused: skip the pose: it is out of reach, an axis missed its target after all retries, no
  // pixel sees the sample, or every channel is saturated at the shortest exposure. Any other error
  // ends the session: the axes have been stopped.
  //
  // `frames`: once a frame suits, it is repeated until there are so many, or as many as the rig
  // allows a pose.
  //
  // A light with colours: all this in each colour, one after the other. What the first says of a
  // prediction that was wrong, those that follow are told.
  Result<PoseRecord> Measure(const DirectionPair& pair, const std::optional<Rgb>& expected,
                             std::stop_token stop, int frames = 1);

  // The same where the arms are told where to go, not what to look at: for a pose that was measured
  // before, which others would reach differently.
  Result<PoseRecord> MeasureAt(const AxisPositions& arms, const std::optional<Rgb>& expected,
                               std::stop_token stop, int frames = 1);
  // Goes where another measurer has left the arms, and measures nothing.
  Result<void> Restore(const MeasurerState& state, std::stop_token stop);
  // Goes there, by a way that touches nothing.
  Result<void> GoTo(const AxisPositions& arms, std::stop_token stop);

  // Whether it was an axis that the last error of any of these was about.
  bool axes_failed() const { return axes_failed_; }

  const MeasurerState& state() const { return state_; }
  // Where the arms are, by their encoders.
  const AxisPositions& position() const { return position_; }

 private:
  // Where to go from `position_`.
  using FindPath = std::function<Result<Path>()>;
  Result<PoseRecord> MeasureOrStop(const FindPath& find, const std::optional<Rgb>& expected,
                                   std::stop_token stop, int frames);
  Result<PoseRecord> MeasureOrFail(const FindPath& find, const std::optional<Rgb>& expected,
                                   std::stop_token stop, int frames);
  Result<void> Move(const FindPath& find, PoseRecord& record, std::stop_token stop);
  Result<void> CheckStood(const AxisPositions& readback);
  // The frames in one colour of the light.
  struct Turn {
    std::optional<LightColour> colour;
    std::size_t begin = 0;  // of its exposures in the record
    double lift = 1;        // light over what was expected, by the colours before it
  };
  Result<void> Expose(const std::optional<Rgb>& expected, int frames, PoseRecord& record,
                      std::stop_token stop);
  // Whether another exposure would have helped.
  Result<bool> ExposeUntilUsable(const std::optional<Rgb>& expected, Turn& turn, PoseRecord& record,
                                 std::stop_token stop);
  Seconds FirstOf(const std::optional<Rgb>& expected, const Turn& turn, double monitor,
                  const PoseRecord& record) const;
  void Learn(const Rgb& predicted, Turn& turn, const PoseRecord& record);
  Rgb Predicted(const std::optional<Rgb>& expected, double monitor, const PoseRecord& record) const;
  Result<void> RepeatSuited(int frames, const Turn& turn, PoseRecord& record, std::stop_token stop);
  Result<void> AddExposure(Seconds exposure, double monitor, const Turn& turn, PoseRecord& record,
                           std::stop_token stop);

  const RigConfig& rig_;
  Devices& devices_;
  Clock& clock_;
  const SiteMask* const bad_;
  FrameTaker taker_;
  ColourChanger colours_;
  PathPlanner paths_;
  AxisPositions position_{};
  MeasurerState state_;
  bool axes_failed_ = false;
};

}  // namespace gonio
