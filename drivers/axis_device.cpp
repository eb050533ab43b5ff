// SPDX-License-Identifier: Apache-2.0
#include "drivers/axis_device.h"

#include <algorithm>
#include <iterator>
#include <vector>

#include "core/units.h"

namespace gonio {
namespace {

using Flow = SerialSettings::Flow;

struct Protocol {
  const char* name;
  AxisProtocol protocol;
  int baud;
  Flow flow;
  int addresses;  // 1 .. this
  int axes;       // of one controller
  bool needs_stage;
};

constexpr Protocol kProtocols[] = {
    {"zaber", AxisProtocol::kZaber, 115200, Flow::kNone, 99, 9, false},
    {"smc100", AxisProtocol::kSmc100, 57600, Flow::kXonXoff, 31, 1, false},
    {"conex-cc", AxisProtocol::kSmc100, 921600, Flow::kXonXoff, 31, 1, false},
    {"esp301", AxisProtocol::kEsp301, 19200, Flow::kRtsCts, 1, 3, false},
    {"grbl", AxisProtocol::kGrbl, 115200, Flow::kNone, 1, 4, false},
    // A controller that is not on a daisy chain is 0.
    {"gcs2", AxisProtocol::kGcs2, 115200, Flow::kNone, 16, 16, false},
    // Addresses are bays of a rack; a controller without bays is 0.
    {"apt", AxisProtocol::kApt, 115200, Flow::kRtsCts, 10, 4, true},
};

const Protocol& ReadProtocol(const ConfigNode& node) {
  std::vector<std::string> names;
  for (const Protocol& protocol : kProtocols) names.emplace_back(protocol.name);
  const std::string name = node.Choice("driver", names);
  return *std::find_if(std::begin(kProtocols), std::end(kProtocols),
                       [&](const Protocol& protocol) { return protocol.name == name; });
}

Flow ReadFlow(const ConfigNode& node, Flow usual) {
  if (!node.Has("flow")) return usual;
  const std::string flow = node.Choice("flow", {"none", "rts-cts", "xon-xoff"});
  return flow == "none" ? Flow::kNone : flow == "rts-cts" ? Flow::kRtsCts : Flow::kXonXoff;
}

}  // namespace

AxisDevice ReadAxisDevice(const ConfigNode& node) {
  const Protocol& protocol = ReadProtocol(node);
  AxisDevice device;
  device.where = node.Where();
  device.protocol = protocol.protocol;
  device.port.port = node.Text("port");
  device.port.baud = node.IntegerOr("baud", protocol.baud, 1, 4000000);
  device.port.flow = ReadFlow(node, protocol.flow);
  const bool alone =
      protocol.protocol == AxisProtocol::kApt || protocol.protocol == AxisProtocol::kGcs2;
  const int first = alone ? 0 : 1;
  device.address = node.IntegerOr("address", first, first, protocol.addresses);
  if (protocol.needs_stage) device.stage = node.Text("stage");
  device.axis = node.IntegerOr("axis", 1, 1, protocol.axes);
  device.zero = RadFromDeg(node.NumberOr("zero_deg", 0, Range::Between(-360, 360)));
  device.turned = node.BoolOr("turned", false);
  return device;
}

}  // namespace gonio
