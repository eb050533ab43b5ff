// SPDX-License-Identifier: Apache-2.0
// One Grbl and all of its axes.

#pragma once

#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/clock.h"
#include "drivers/controller_axis.h"
#include "drivers/grbl_line.h"

namespace gonio::grbl {

// Shared by the axes it drives. Any thread, one exchange at a time. Grbl counts in millimetres,
// which are degrees here: of position, per minute ($110), per second squared ($120).
//
// Axes move at the same time although Grbl makes one move after the other: one that is told to move
// while others are on their way brakes them (a jog that is cancelled loses nothing), and all go on
// from there together, in legs (drivers/grbl_legs.h). An axis has arrived once its own position is
// there, even while others go on. The price: each start brakes those that began before it.
//
// What Grbl cannot do for one axis it does to all: a stop stops all, homing homes all, and a reset
// or an alarm loses the position of all. An axis whose move another one's stop has ended finds
// itself beside its target.
class Machine {
 public:
  struct Times {
    Seconds reply{1};
    // Until it is up after its port was opened, which resets most Arduinos. Those that stay as they
    // were say nothing for so long, and are not homed either: nobody knows what became of them.
    Seconds boot{3};
  };

  // Finds out what is there. kTimeout: nothing that answers; kRefused: not Grbl 1.1, or in a state
  // that only its operator should end. `clock` outlives the machine.
  static Result<std::shared_ptr<Machine>> Open(std::unique_ptr<ByteLink> link, Clock* clock,
                                               const Times& times);

  const std::string& identity() const { return identity_; }
  int axes() const { return axes_; }
  // Whether it was compiled with this option: a letter of "[OPT:".
  bool HasOption(char letter) const { return options_.find(letter) != std::string::npos; }
  Result<double> Setting(int number);
  // Kept by Grbl until it is changed again; left alone if it has this value. kRefused: reads
  // otherwise.
  Result<void> Set(int number, double value);
  // How far from where it should be an axis that is there may be read [deg]: half a step, and the
  // rounding of reports.
  Result<double> Resolution(int axis);

  // Of one axis, as drivers/controller_axis.h wants it. Positions are what it has stepped, not
  // what an encoder says.
  Result<ControllerStatus> Status(int axis);
  // Homes all; nothing if another axis had all homed since this one was last homed or moved.
  Result<void> StartHoming(int axis);
  // To `target` [deg] at `speed` [deg/s]. Returns once others have braked and all are on their way,
  // kCancelled if they were told to stop meanwhile.
  Result<void> StartMove(int axis, double target, double speed);
  // Brakes; a homing can only be reset, without braking.
  Result<void> Stop();
  // A reset, without braking.
  Result<void> EmergencyStop();
  // Out of every state that nothing else ends.
  Result<void> Reset();

 private:
  struct Goal {
    double target;  // deg
    double speed;   // deg/s
  };

  Machine(std::unique_ptr<ByteLink> link, Clock* clock, const Times& times);
  Result<void> Identify(Seconds boot);
  Result<void> ReadSettings();
  // Those below are called with the lock held.
  Result<double> Get(int number) const;
  Result<Report> Ask();
  Result<Report> Brake(unsigned stops);
  Result<Report> AwaitIdle(unsigned stops);
  Result<void> MayMove() const;
  Result<Report> MustBeIdle(const Report& report) const;
  Result<void> SendLegs(const Report& report);
  bool IsMoving(int axis, const Report& report) const;
  bool IsThere(int axis, const Report& report) const;
  Error Refused(const std::string& why) const;

  std::mutex mutex_;
  Line line_;
  Clock* const clock_;
  std::string identity_;
  std::string options_;
  int axes_ = 0;
  std::map<int, std::string> settings_;
  std::array<std::optional<Goal>, kMostAxes> goals_;  // of axes on their way
  // The homing that each axis relies on, by number; 0: none.
  std::array<unsigned, kMostAxes> relies_on_{};
  std::atomic<unsigned> stops_ = 0;  // that were asked for
};

}  // namespace gonio::grbl
