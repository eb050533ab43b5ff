// SPDX-License-Identifier: Apache-2.0
// Doubles of all the controllers of a rig, each at the end of the line that the rig file says.

#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/clock.h"
#include "drivers/axis.h"
#include "drivers/axis_device.h"
#include "sim/grbl_emulator.h"
#include "sim/pty_server.h"

namespace gonio {

// Pseudo-terminals with emulated controllers behind them; those that the rig puts on one port share
// one. Their stages have room for the limits of the rig, and move in the time of `clock`.
class WireBench {
 public:
  explicit WireBench(std::shared_ptr<Clock> clock) : clock_(std::move(clock)) {}
  WireBench(WireBench&&) = default;

  // Adds a controller. Once Serve() was called there are no more.
  void Add(const AxisDevice& device, const AxisLimits& limits);
  void Serve();

  // Of the axes in the order they were added: the pseudo-terminal, and where the mechanism is
  // [rad].
  const std::string& PathOf(std::size_t axis) const;
  double Angle(std::size_t axis) const { return axes_[axis].angle(); }

  // Faults of its controller: power fails and comes back; the motor's power is cut. Any thread.
  void Reset(std::size_t axis) { axes_[axis].reset(); }
  void CutMotorPower(std::size_t axis) { axes_[axis].cut_power(); }
  // Plugs a line that hung up in again, at another path.
  void Replug(const std::string& port) { lines_.at(port) = Line(port); }

  // By port as the rig file names it.
  const std::map<std::string, std::unique_ptr<PtyServer>>& lines() const { return lines_; }

 private:
  using Receive = std::function<std::string(std::string_view)>;
  struct Stage {
    std::string port;
    std::function<double()> angle;
    std::function<void()> reset;
    std::function<void()> cut_power;
  };

  // The axes of one board are added one by one, and then it is made.
  struct Board {
    GrblBoard settings;
    std::shared_ptr<GrblEmulator> emulator;
  };

  std::unique_ptr<PtyServer> Line(const std::string& port);
  void AddGrbl(const AxisDevice& device, const AxisLimits& limits);
  template <typename Emulator, typename Settings>
  void AddEmulator(const AxisDevice& device, const Settings& settings);

  std::shared_ptr<Clock> clock_;
  std::vector<Stage> axes_;
  std::map<std::string, std::vector<Receive>> controllers_;  // by port
  std::map<std::string, std::shared_ptr<Board>> boards_;     // the same
  std::map<std::string, std::unique_ptr<PtyServer>> lines_;
};

}  // namespace gonio
