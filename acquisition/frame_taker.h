// SPDX-License-Identifier: Apache-2.0
// One exposure with the monitor reading that belongs to it.

#pragma once

#include <array>
#include <deque>
#include <optional>
#include <stop_token>
#include <string>

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

  // With RigConfig::max_light_change: whether the light, just switched on, flickers by more than
  // that from reading to reading (rms of kSteadyReadings), kProtocol; else nothing is looked at. A
  // light that flickers passes the comparison below now and then.
  Result<void> CheckSteady(Clock& clock);

  // One frame under the light that the monitor, read just before, says. With
  // RigConfig::max_light_change it is read again afterwards: the frame's is the mean of the two,
  // and a frame between two that differ by more is taken again, up to kTries times; then kProtocol.
  // So it is where the last kSteadyReadings pairs, good or not, differ by more on the average.
  // Exposure::saturated is left for the caller, who knows which pixels matter.
  Result<Exposure> Take(Seconds exposure, double monitor, std::stop_token stop);

  // One frame with the light off, of which no monitor has anything to say.
  Result<Frame> TakeDark(Seconds exposure, std::stop_token stop);

  static constexpr int kTries = 3;
  static constexpr std::size_t kSteadyReadings = 8;
  static constexpr Seconds kBetweenReadings{0.02};

 private:
  Error Unsteady(const std::string& how) const;
  const RigConfig& rig_;
  Devices& devices_;
  std::deque<double> changes_;  // relative, the last ones
};

}  // namespace gonio
