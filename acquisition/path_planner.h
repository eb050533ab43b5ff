// SPDX-License-Identifier: Apache-2.0
// Ways of the arms around what they must not touch.

#pragma once

#include <span>
#include <vector>

#include "acquisition/keep_out.h"
#include "acquisition/kinematics.h"

namespace gonio {

// One leg: all axes start together, each by way of its turning point (drivers/move_time.h), and all
// are still before the next leg begins.
using Path = std::vector<AxisPositions>;  // where the legs end; the last is the target

// Threads: any, at the same time.
class PathPlanner {
 public:
  explicit PathPlanner(const RigConfig& rig);

  const Kinematics& kinematics() const { return kinematics_; }

  // Whether there is nothing to keep away from: every way is straight.
  bool free() const { return keep_out_.empty(); }

  // Every leg keeps the margin whatever the speeds of its axes (KeepOut::FindBetween). Tried in
  // this order, the first that is free is taken:
  //
  //   1. all axes together;
  //   2. the axes one after the other or in groups, the fastest free order: nothing moves away from
  //      where it has to go;
  //   3. around: a search over positions 45 deg apart, 22.5 deg of elevations, tilts and arms in a
  //      plane, one axis at a time, shortened where a leg can be left out.
  //
  // kRefused: no way was found, or the target itself is too near; the message says what is in the
  // way. kProtocol: `from` is too near already, so no move is safe: by hand only.
  Result<Path> Plan(const AxisPositions& from, const AxisPositions& to) const;

  // The same to a position that realises `pair`: the sooner one is reached, the sooner it is tried.
  // kRefused also if the pair is out of reach.
  Result<Path> PlanTo(const AxisPositions& from, const DirectionPair& pair) const;

  // Sum of the legs, without settling.
  Seconds TravelTime(const AxisPositions& from, const Path& path) const;

  // Of each pose, whether it has a position and a way to it from the others: of the groups of poses
  // that are connected, the largest is kept.
  std::vector<bool> Connected(std::span<const DirectionPair> poses) const;

 private:
  std::optional<Contact> FindOnLeg(const AxisPositions& from, const AxisPositions& to) const;
  std::optional<Path> PlanInOrder(const AxisPositions& from, const AxisPositions& to) const;
  std::optional<Path> PlanAround(const AxisPositions& from, const AxisPositions& to) const;
  Path Shortened(const AxisPositions& from, Path path) const;

  KeepOut keep_out_;
  Kinematics kinematics_;
  RigKind kind_;
  std::array<AxisLimits, kAxes> axes_;     // of the axes themselves
  std::array<AxisLimits, kAxes> targets_;  // of targets
};

}  // namespace gonio
