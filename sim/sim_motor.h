// SPDX-License-Identifier: Apache-2.0
// The mechanism behind a simulated axis: where it truly is.

#pragma once

#include <mutex>

#include "core/clock.h"

namespace gonio {

// A shaft that follows trapezoidal speed profiles in the time of a Clock. It outlives the SimAxis
// that drives it, so that the camera, and a test, can see what the driver left behind. Any thread.
//
// Simplified: Stop() brakes at once, and a move started during another one starts from rest.
class SimMotor {
 public:
  // Rests at `position` [rad]; speed in rad/s, acceleration in rad/s^2. Every move, however short,
  // ends `overhead` after it has covered its distance.
  SimMotor(double position, double max_speed, double acceleration, const Clock& clock,
           Seconds overhead = Seconds(0));

  // Starts for `target` [rad] at this fraction of the full speed.
  void Start(double target, double speed_fraction = 1);
  void Stop();

  double Position() const { return PositionAt(clock_.Now()); }
  // At a time not before the start of the current move; the future is what will happen if nobody
  // interferes.
  double PositionAt(Seconds time) const;
  bool Moving() const { return Remaining() > Seconds::zero(); }
  bool MovingBetween(Seconds begin, Seconds end) const;
  // Until the current move ends.
  Seconds Remaining() const;

 private:
  struct Move {
    double from = 0;
    double to = 0;
    double speed = 1;
    Seconds start{0};
    Seconds duration{0};
  };
  double PositionAtLocked(Seconds time) const;

  const double max_speed_;
  const double acceleration_;
  const Seconds overhead_;
  const Clock& clock_;
  mutable std::mutex mutex_;
  Move move_;
};

}  // namespace gonio
