// SPDX-License-Identifier: Apache-2.0
// Instruments of the USB test and measurement class, by libusb.

#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/message_link.h"
#include "drivers/usb_interface.h"
#include "drivers/usbtmc_codec.h"

namespace gonio {

class Deadline;

// All instruments of this class that are plugged in, by vendor, product and serial number.
Result<std::vector<UsbDeviceInfo>> ListUsbtmcDevices();

// An instrument, exclusively ours until destroyed. The system's own driver (usbtmc) is asked to let
// go of it, and gets it back.
//
// Promises, checked by tests/usb/usbtmc_test.cpp:
//
//   1. A message of any length goes out whole, and one of up to kMostBytes comes in whole; its last
//      byte is the device's, a line end if it sends one.
//   2. Every call returns within its limit and kRecoveryLimit, which is spent after errors only: a
//      transfer that was given up is aborted as the class prescribes, the device cleared if that
//      does not help. Then the next message goes through.
//   3. After kDisconnected every later call returns kDisconnected. A device that was plugged in
//      again is opened again.
//
// Any thread, one call at a time.
class UsbtmcDevice final : public MessageLink {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{1} << 20;
  static constexpr Seconds kRecoveryLimit{3};

  // kRefused: no such device (the message lists those there are), several of them and no serial
  // number given, no permission, in use by another program. kProtocol: it does not do what the
  // class demands.
  static Result<std::unique_ptr<UsbtmcDevice>> Open(const UsbSelection& selection);

  const std::string& name() const override { return usb_->name(); }
  const usbtmc::Capabilities& capabilities() const { return capabilities_; }
  Result<void> Write(std::string_view message, Seconds limit) override;
  Result<std::string> Read(Seconds limit) override;
  Result<void> Clear() override;

 private:
  struct Part;  // of a message that came in

  explicit UsbtmcDevice(std::unique_ptr<UsbInterface> usb) : usb_(std::move(usb)) {}

  std::uint8_t NewTag() { return tag_ = usbtmc::NextTag(tag_); }
  Result<Part> ReadPart(const Deadline& deadline);
  Result<std::string> ReadParts(const Deadline& deadline);
  Result<usbtmc::StatusReply> Ask(usbtmc::Request request, UsbInterface::About about,
                                  std::uint16_t value, const Deadline& deadline);
  // Asks `check` until the device is done, reading away what it still has to say.
  Result<void> AwaitEnd(usbtmc::Request check, UsbInterface::About about, const Deadline& deadline);
  Result<void> ReadAway(const Deadline& deadline);

  // What is left of `error` after everything was done that lets the next message through.
  Error AfterFailedWrite(const Error& error);
  Error AfterFailedRead(const Error& error);
  Error AfterNonsense(const Error& error);
  Result<void> AbortOut(const Deadline& deadline);
  Result<void> AbortIn(const Deadline& deadline);
  Result<void> ClearAll(const Deadline& deadline);
  Error Outcome(const Error& error, const Result<void>& recovery);
  // A time-out of one transfer, told as that of the whole message.
  Error InAll(const Error& error, const char* missing, const Deadline& deadline) const;
  Error About(const Error& error) const;

  std::mutex mutex_;
  const std::unique_ptr<UsbInterface> usb_;
  usbtmc::Capabilities capabilities_;
  std::uint8_t tag_ = 0;  // of the last transfer
  bool stuck_ = false;    // a recovery has failed: it comes before the next message
};

}  // namespace gonio
