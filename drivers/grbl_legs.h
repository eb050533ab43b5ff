// SPDX-License-Identifier: Apache-2.0
// Several axes of one Grbl under way together.

#pragma once

#include <vector>

#include "drivers/grbl_codec.h"

namespace gonio::grbl {

// What an axis has still to do, in degrees and degrees per second.
struct Way {
  int axis = 0;  // 0 .. kMostAxes - 1, each at most once
  double from = 0;
  double to = 0;
  double speed = 0;  // > 0
};

// Grbl makes one straight move after the other, and in each all axes begin and end together. So
// axes that need different times go in legs: all of them until the first is there, the others
// until the next one is, and so on, each at its own speed throughout. Ends less than a twentieth
// of a second apart become one. Empty: all are there.
std::vector<Leg> LegsOf(const std::vector<Way>& ways);

}  // namespace gonio::grbl
