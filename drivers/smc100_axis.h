// SPDX-License-Identifier: Apache-2.0
// A rotary stage behind Newport's SMC100CC, SMC100PP or CONEX controller.

#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "drivers/controller_axis.h"
#include "drivers/line_reader.h"

namespace gonio::smc100 {

// The controllers on one serial line (SMC100: 57600 baud, XON/XOFF; CONEX-CC: 921600 baud). Any
// thread, one exchange at a time.
class Line {
 public:
  static constexpr Seconds kReplyLimit{1};

  explicit Line(std::unique_ptr<ByteLink> link, Seconds reply_limit = kReplyLimit);

  // What a query answers, its echo of address and command taken off. Asked again if the answer does
  // not come or is garbled. Answers carry no number: one that comes too late and after the same
  // question was asked again is taken for the second's, so may be older than it by reply_limit.
  Result<std::string> Query(int address, const std::string& command, const std::string& argument);
  // A command answers nothing, and one that is not obeyed is passed over in silence: so its error
  // is asked for (TE). kRefused: that says why not.
  Result<void> Command(int address, const std::string& command);
  // Brakes: sent before anything is asked, and never kRefused, as it is where there is nothing to
  // stop.
  Result<void> Stop(int address);

 private:
  Result<std::string> Exchange(int address, const std::string& command,
                               const std::string& argument);

  std::mutex mutex_;
  std::unique_ptr<ByteLink> link_;
  LineReader lines_;
  Seconds reply_limit_;
};

// Opens an axis (drivers/controller_axis.h has its rules) that counts in degrees. Its soft limits
// (SL, SR) must include the settings'; velocity and acceleration are set and
// read back, now and before each homing, since a reset forgets them. It is homed
// but in the states called NOT REFERENCED, and while homing; one that is homed is not homed again.
//
// kRefused: limits outside the controller's, a speed it cannot have. Moves nothing. `line` may be
// shared with other axes; `clock` outlives the axis.
Result<std::unique_ptr<Axis>> OpenAxis(std::shared_ptr<Line> line, int address,
                                       const ControllerAxisSettings& settings, Clock* clock);

}  // namespace gonio::smc100
