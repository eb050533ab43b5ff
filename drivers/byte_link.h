// SPDX-License-Identifier: Apache-2.0
// A link that carries bytes both ways, as drivers use it.

#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "core/clock.h"
#include "core/error.h"

namespace gonio {

// A serial port (drivers/serial_port.h). Knows nothing of lines, packets or who asked what.
//
// Promises, checked by tests/drivers/serial_port_test.cpp:
//
//   1. Bytes arrive as they were sent, all 256 of them, and in order.
//   2. Every call returns within its limit and 100 ms: with kTimeout while the far end is there and
//      silent, with kDisconnected once it is gone. Waiting costs no processor time.
//   3. After kDisconnected every later call returns kDisconnected. No call reconnects behind the
//      caller's back.
//
// One thread at a time. Errors: kTimeout, kDisconnected; messages begin with name().
class ByteLink {
 public:
  virtual ~ByteLink() = default;
  virtual const std::string& name() const = 0;
  // Hands over all bytes. kTimeout: the line takes no more (flow control); how many it took nobody
  // knows, so what follows must resynchronise.
  virtual Result<void> Write(std::string_view bytes, Seconds limit) = 0;
  // What has come in, one byte at least and `most` at most, as soon as there is any.
  virtual Result<std::string> Read(std::size_t most, Seconds limit) = 0;
  // Forgets what has come in and was not read.
  virtual Result<void> DiscardInput() = 0;
};

}  // namespace gonio
