// SPDX-License-Identifier: Apache-2.0
// A serial port, by libserialport.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/byte_link.h"

namespace gonio {

class Deadline;

struct SerialSettings {
  enum class Flow { kNone, kRtsCts, kXonXoff };
  enum class Parity { kNone, kEven, kOdd };

  // "/dev/ttyUSB0" or a link to it, or "usb:SERIAL" for the port of the USB adapter with that
  // serial number, which stays the same whatever is plugged in first.
  std::string port;
  int baud = 115200;  // > 0; 8 data bits, as all of our devices have
  int stop_bits = 1;  // 1, 2
  Parity parity = Parity::kNone;
  Flow flow = Flow::kNone;
  // Levels of the two lines while the port is open. Raising DTR resets most Arduinos, and the
  // system raises both for an instant whenever a port is opened, whatever is asked for here. With
  // kRtsCts the driver moves RTS itself.
  bool dtr = true;
  bool rts = true;
};

// What is known of a port without opening it; empty where the system does not say.
struct SerialPortInfo {
  std::string path;         // "/dev/ttyUSB0"
  std::string description;  // "FT232R USB UART - A1"
  std::string usb_id;       // "0403:6001"
  std::string usb_serial;   // "A1"
};

// All ports of this machine, by path. kRefused: the system does not tell.
Result<std::vector<SerialPortInfo>> ListSerialPorts();

// An open port: exclusively ours until destroyed, since two programs that share one read each
// other's replies. Raw: no byte is changed or swallowed.
//
// libserialport's blocking calls are not used: once a USB adapter is pulled out they look like a
// time-out, which they spend spinning.
class SerialPort final : public ByteLink {
 public:
  // kRefused: no such port, no permission, in use by another program, settings it cannot have. What
  // came in before is discarded.
  static Result<std::unique_ptr<SerialPort>> Open(const SerialSettings& settings);
  ~SerialPort() override;

  const std::string& name() const override { return name_; }
  Result<void> Write(std::string_view bytes, Seconds limit) override;
  Result<std::string> Read(std::size_t most, Seconds limit) override;
  Result<void> DiscardInput() override;

 private:
  struct Handle;  // libserialport's

  SerialPort(std::string name, std::unique_ptr<Handle> handle);
  // Until the events of poll(2) can be served, or a reason why not.
  Result<void> WaitFor(short events, const Deadline& deadline, const char* doing);
  Error TooLate(const Deadline& deadline, const char* doing) const;
  Error Gone();

  std::string name_;
  std::unique_ptr<Handle> handle_;
  bool gone_ = false;
};

}  // namespace gonio
