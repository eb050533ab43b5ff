// SPDX-License-Identifier: Apache-2.0
// A link that carries whole messages both ways, as instruments that talk SCPI use it.

#pragma once

#include <string>
#include <string_view>

#include "core/clock.h"
#include "core/error.h"

namespace gonio {

// Where a message ends the link knows (drivers/usbtmc.h), so nothing is searched for line ends.
//
// One call at a time. Errors: kTimeout, kDisconnected (then every later call returns it),
// kProtocol; messages begin with name(). After each error but kDisconnected the next message can be
// sent, but an answer that is still owed may come before its own.
class MessageLink {
 public:
  virtual ~MessageLink() = default;
  virtual const std::string& name() const = 0;
  virtual Result<void> Write(std::string_view message, Seconds limit) = 0;
  // The next message of the device.
  virtual Result<std::string> Read(Seconds limit) = 0;
  // Has the device forget what it was told and has not answered.
  virtual Result<void> Clear() = 0;
};

}  // namespace gonio
