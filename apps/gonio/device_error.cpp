// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/device_error.h"

namespace gonio {
namespace {

constexpr std::size_t kLines = 10;

}  // namespace

DeviceError::DeviceError(const std::string& what, const LinkLog& wires)
    : std::runtime_error(what), wires_(LastOnTheWires(wires)) {}

std::string LastOnTheWires(const LinkLog& wires) {
  const std::string lines = wires.Last(kLines);
  return lines.empty() ? lines : "last on the wires (s, > sent, < received):\n" + lines;
}

}  // namespace gonio
