// SPDX-License-Identifier: Apache-2.0
// One interface of a USB device, by libusb.

#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"
#include "core/error.h"

namespace gonio {

// Interfaces are found by what they are for; their numbers differ between firmwares.
struct UsbClass {
  int code = 0;
  int subclass = 0;
  const char* what = "";  // "USB test and measurement"
};

// What is known of a device; the texts are empty where it may not be opened.
struct UsbDeviceInfo {
  int vendor = 0;
  int product = 0;
  std::string serial;
  std::string description;
};

struct UsbSelection {
  int vendor = 0;
  std::vector<int> products;  // any of them
  std::string serial;         // empty: the only one that is plugged in
};

// Claimed: exclusively ours until destroyed. The system's own driver, if it had one, is asked to
// let go and given it back. Each has a libusb context of its own, so that they share nothing.
//
// One call at a time. Errors: kTimeout, kDisconnected (the device is out: then for good, a device
// that is plugged in again is opened again), kProtocol (a stalled endpoint, or more bytes than
// fit); messages begin with name().
class UsbInterface {
 public:
  // All devices that have such an interface. kRefused: the system does not tell.
  static Result<std::vector<UsbDeviceInfo>> List(const UsbClass& which);
  // kRefused: no such device, several, no permission, in use; the message says what to do.
  static Result<std::unique_ptr<UsbInterface>> Open(const UsbSelection& selection,
                                                    const UsbClass& which);
  ~UsbInterface();

  const std::string& name() const { return name_; }  // "USB 1313:8078 P0012345"
  // Bytes of the largest packet that comes in.
  std::size_t packet_bytes() const { return packet_bytes_; }

  // Bulk endpoints. A read ends with a packet that is not full, or when `most` bytes, a multiple of
  // packet_bytes(), have come.
  Result<void> Write(std::string_view bytes, Seconds limit);
  Result<std::string> Read(std::size_t most, Seconds limit);
  // A class request that is answered: to the interface, or about one of the endpoints.
  enum class About { kInterface, kOut, kIn };
  Result<std::string> Ask(std::uint8_t request, std::uint16_t value, About about,
                          std::uint16_t most, Seconds limit);
  // Of a stalled endpoint.
  Result<void> ClearHalt(About endpoint);

 private:
  struct Handle;  // libusb's

  explicit UsbInterface(std::unique_ptr<Handle> handle, std::string name);
  // `result` is libusb's.
  Error Failed(int result, const char* doing, Seconds limit);

  const std::unique_ptr<Handle> handle_;
  const std::string name_;
  std::size_t packet_bytes_;
  bool gone_ = false;
};

}  // namespace gonio
