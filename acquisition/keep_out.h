// SPDX-License-Identifier: Apache-2.0
// What arms and sample must not touch: each other, the table, the post; and how far the arms'
// cables reach. docs/geometry.md has a drawing.

#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "acquisition/rig.h"

namespace gonio {

// A position of the axes that is not allowed, or that could not be shown to be.
struct Contact {
  std::string first;     // "light_arm 1", "sample 2", "fixed 1": the part, counted from 1
  std::string second{};  // empty: it is the cables that do not reach
  AxisPositions at{};    // true ones
  double gap = 0;        // m between the surfaces; zero if they are inside each other
  std::span<const char* const> axes{};  // their names

  // "light_arm 1 and camera_arm 1 come within 12.0 mm at light azimuth 10.0, ... deg".
  std::string Text() const;
};

// The solids of a rig at any true positions of its axes (Kinematics::TruePositions). Threads: any,
// at the same time.
class KeepOut {
 public:
  explicit KeepOut(const RigConfig& rig);
  ~KeepOut();
  KeepOut(KeepOut&&) noexcept;
  KeepOut& operator=(KeepOut&&) noexcept;

  // Whether the rig file names anything to keep away from.
  bool empty() const;

  // What is nearer than the margin; nullopt: nothing.
  std::optional<Contact> FindAt(const AxisPositions& positions) const;

  // The same for every position in which each axis is anywhere between its two: whatever the speeds
  // of the axes are and whoever arrives first, they stay inside this box. nullopt is a proof: all
  // axes meet in the origin, so from the middle of a piece of the box no point of a solid gets
  // further away than its distance from the origin times the angles, so a gap that is larger clears
  // the piece at once; others are halved. A piece of 1/4 deg that is not cleared counts as a
  // contact.
  std::optional<Contact> FindBetween(const AxisPositions& low, const AxisPositions& high) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gonio
