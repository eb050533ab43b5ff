// SPDX-License-Identifier: Apache-2.0
// One exposure with the monitor reading that belongs to it.

#pragma once

#include <array>
#include <optional>
#include <stop_token>

#include "acquisition/rig.h"

namespace gonio {

// One frame with what is needed to reduce it.
struct Exposure {
  Frame frame;
  // Of the light; the frame then stands for this channel alone. Empty: the light has no colours.
  std::optional<LightColour> colour;
  double monitor = 1;                       // the monitor's reading that belongs to this frame
  std::array<bool, kChannels> saturated{};  // some pixel of the channel reached full scale
};

// Takes frames with opened devices and lets none pass that is not whole or was lit unsteadily. One
// thread.
class FrameTaker {
 public:
  // Keeps references; both must outlive it.
  FrameTaker(const RigConfig& rig, Devices& devices) : rig_(rig), devices_(devices) {}

  // The monitor's reading. kProtocol: there is none, or it says that the light is out.
  Result<double> ReadMonitor();

  // One frame under the light that the monitor, read just before, says. With
  // RigConfig::max_light_change it is read again afterwards: the frame's is the mean of the two,
  // and a frame between two that differ by more is taken again, up to kTries times; then kProtocol.
  // Exposure::saturated is left for the caller, who knows which pixels matter.
  Result<Exposure> Take(Seconds exposure, double monitor, std::stop_token stop);

  // One frame with the light off, of which no monitor has anything to say.
  Result<Frame> TakeDark(Seconds exposure, std::stop_token stop);

  static constexpr int kTries = 3;

 private:
  const RigConfig& rig_;
  Devices& devices_;
};

}  // namespace gonio
