// SPDX-License-Identifier: Apache-2.0
// Opens the axes of a rig. The one place that chooses between protocols.

#pragma once

#include <map>
#include <memory>
#include <string>
#include <variant>

#include "drivers/axis_device.h"
#include "drivers/controller_axis.h"
#include "drivers/link_log.h"

namespace gonio {

namespace apt {
class Link;
}
namespace esp301 {
class Line;
}
namespace gcs2 {
class Line;
}
namespace grbl {
class Machine;
}
namespace smc100 {
class Line;
}
namespace zaber {
class Chain;
}

// Axes with the same port share its line. One thread.
class AxisOpener {
 public:
  // `clock` outlives the axes.
  AxisOpener(Clock* clock, std::shared_ptr<LinkLog> log) : clock_(clock), log_(std::move(log)) {}

  // Nothing moves. settings.scale is what `device` says. kRefused: the port cannot be opened, or
  // another axis has opened it for another protocol, or the controller cannot do what the settings
  // ask for; kTimeout, kProtocol: no such controller answers there.
  Result<std::unique_ptr<Axis>> Open(const AxisDevice& device, ControllerAxisSettings settings);

 private:
  using Line = std::variant<std::shared_ptr<zaber::Chain>, std::shared_ptr<smc100::Line>,
                            std::shared_ptr<apt::Link>, std::shared_ptr<esp301::Line>,
                            std::shared_ptr<gcs2::Line>, std::shared_ptr<grbl::Machine>>;
  struct Opened {
    AxisDevice by;
    Line line;
  };

  // The line of an axis opened before, if this one can have it, too.
  Result<Line> Shared(const Opened& opened, const AxisDevice& device) const;
  Result<Line> LineOf(const AxisDevice& device);
  Result<Line> OpenLine(const AxisDevice& device);

  Clock* const clock_;
  const std::shared_ptr<LinkLog> log_;
  std::map<std::string, Opened> lines_;  // by port as the rig file names it
};

}  // namespace gonio
