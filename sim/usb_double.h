// SPDX-License-Identifier: Apache-2.0
// A USB device that is not there.

#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace gonio {

struct UsbPlate {  // what is written on it
  int vendor = 0;
  int product = 0;
  std::string maker;
  std::string description;
  std::string serial;
};

// What became of a transfer.
struct UsbOutcome {
  enum class Kind { kDone, kStalled, kLater };  // later: the device is asked again
  Kind kind = Kind::kDone;
  std::string bytes;  // that the device sent
};

struct UsbSetup {  // the eight bytes before a control transfer
  std::uint8_t type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
  std::uint16_t length = 0;
};

// As its host controller sees it; sim/usb_bench.h plugs it in. Calls come from the bench's thread
// and must not wait.
class UsbDouble {
 public:
  virtual ~UsbDouble() = default;
  virtual const UsbPlate& plate() const = 0;
  // Of the device and of its one configuration, as bytes.
  virtual std::string Descriptors() const = 0;
  // Class requests; those that all devices have the bench answers itself.
  virtual UsbOutcome Control(const UsbSetup& setup) = 0;
  virtual UsbOutcome Out(std::string_view bytes) = 0;
  // One transfer of at most so many bytes: ended by a packet that is not full, or by being full.
  virtual UsbOutcome In(std::size_t most) = 0;
  virtual void ClearHalt(std::uint8_t endpoint) = 0;
  // Power is gone, or has come back.
  virtual void Reset() = 0;
};

}  // namespace gonio
