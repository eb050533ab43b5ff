// SPDX-License-Identifier: Apache-2.0
// Thorlabs' rotary stages: what their controllers do not tell.

#pragma once

#include <array>
#include <string>
#include <string_view>

#include "drivers/apt_codec.h"

namespace gonio::apt {

// Controllers count in units of their own, which depend on the stage and on how often the
// controller looks at it, and tell neither. From the protocol's manual.
struct Stage {
  const char* name;
  bool servo;  // a DC motor with an encoder; else a stepper motor, whose position is counted steps
  double counts_per_degree;
  double velocity_per_degree;      // of VELPARAMS, for 1 deg/s
  double acceleration_per_degree;  // for 1 deg/s^2
  // What the serial numbers of controllers that drive it, at this scale, begin with. 0: no more.
  std::array<int, 5> serials;
};

// "PRM1-Z8", "DDR100", "DDR05", "K10CR1", "HDR50" or "NR360". kRefused: another; the message lists
// those there are.
Result<Stage> FindStage(std::string_view name);

// Why a controller does not drive this stage, or not at this scale; empty: it does. A serial number
// it does not know (-1, as cards say) proves nothing.
std::string WhyNotDriven(const Stage& stage, const Info& controller);

}  // namespace gonio::apt
