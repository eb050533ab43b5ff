// SPDX-License-Identifier: Apache-2.0
// A rotary stage behind Newport's ESP301 or ESP300 controller.

#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "drivers/controller_axis.h"
#include "drivers/esp301_codec.h"
#include "drivers/fault_book.h"
#include "drivers/line_reader.h"

namespace gonio::esp301 {

// One controller, for all of its axes (19200 baud, RTS/CTS). Any thread, one exchange at a time.
//
// Answers say neither whose nor what they are. So what has come in is discarded before each
// question; each answer must have the form of its question; and after one that was late or made no
// sense the controller is first asked for its version, which nothing else looks like: what comes
// before that belongs to questions that were given up. What cannot be noticed is a digit that
// turned into another on the line.
class Line {
 public:
  static constexpr Seconds kReplyLimit{1};

  explicit Line(std::unique_ptr<ByteLink> link, Seconds reply_limit = kReplyLimit);

  // Axis 0 is the controller itself. Questions are asked again if their answer does not come or
  // makes no sense.
  Result<std::string> Version();
  Result<std::string> Text(int axis, const std::string& question);
  Result<double> Value(int axis, const std::string& question);
  Result<bool> Flag(int axis, const std::string& question);
  Result<int> Unit(int axis);

  // A command answers nothing, and one that is not obeyed is passed over in silence; so the error
  // queue is emptied before and read after it. kRefused: it says why not.
  Result<void> Command(int axis, const std::string& command);
  // Sent before anything is asked, and never kRefused.
  Result<void> StopCommand(int axis, const std::string& command);
  // Aborts all axes. The controller calls that an emergency stop, too; here it is "aborted".
  Result<void> AbortCommand();

  // Empties the error queue; faults are kept, for each axis until it has been homed again.
  Result<void> ReadErrors();
  int faults() const;  // so many have been noted
  std::string FaultAfter(int faults, int axis) const;

 private:
  template <typename Decode>
  auto Ask(int axis, const std::string& question, Decode decode)
      -> decltype(decode(std::string_view()));
  Result<std::string> Exchange(int axis, const std::string& question);
  Result<void> GetInStep();
  // The first error about this axis or the controller.
  Result<QueuedError> EmptyQueue(int axis);
  Error Refused(int axis, const std::string& what, const QueuedError& why) const;
  Error About(int axis, const std::string& question, const Error& error) const;

  mutable std::mutex mutex_;
  std::unique_ptr<ByteLink> link_;
  LineReader lines_;
  Seconds reply_limit_;
  bool in_step_ = true;   // the next answer will be that of the next question
  bool aborted_ = false;  // by us, and nothing was commanded since
  FaultBook faults_;
};

struct AxisAddress {
  int axis = 1;       // 1 .. 3
  int home_mode = 1;  // OR1 .. OR6: what it is to look for; 1 is the home switch and the index
};

// Opens an axis (drivers/controller_axis.h has its rules), which must count in degrees (SN 7) and
// between whose soft limits (SL, SR) the settings' must lie. Velocity, acceleration and
// deceleration (VA, AC, AG) are set and read back, now and before each homing, since a reset
// forgets them.
//
// The controller does not say whether it is homed. It is if homing (OR) was seen to move and to end
// without an error since this opening, and is no longer once the motor was without power or the
// velocity is no longer what it was set to: both come with a reset. Not noticed is a reset after
// which somebody else switched the motor on again, before the axis was next asked, on a controller
// that has the same velocity saved.
//
// An emergency stop (AB) stops, and as a rule switches off, all axes of the controller.
//
// kRefused: another device, another unit, limits outside the controller's, a speed it cannot have,
// a home mode that proves nothing (OR0). Moves nothing. `line` may be shared with other axes;
// `clock` outlives the axis.
Result<std::unique_ptr<Axis>> OpenAxis(std::shared_ptr<Line> line, const AxisAddress& address,
                                       const ControllerAxisSettings& settings, Clock* clock);

}  // namespace gonio::esp301
