// SPDX-License-Identifier: Apache-2.0
// What Linux does between programs and a USB device (Documentation/driver-api/usb), for one device.

#pragma once

#include <cstdint>
#include <list>
#include <mutex>
#include <optional>
#include <string>

#include "sim/usb_double.h"

namespace gonio {

// Transfers and claims of the programs that have the device open. Knows nothing of how they ask
// (sim/usb_bench.cpp does). Any thread.
class UsbHost {
 public:
  using Program = const void*;  // an open file, by any address of its own
  using Ticket = std::uint64_t;

  struct Transfer {
    enum class Kind { kControl, kBulk };
    Kind kind = Kind::kBulk;
    std::uint8_t endpoint = 0;
    std::string bytes;     // to send; of a control transfer the setup comes first
    std::size_t room = 0;  // for bytes that come in, the setup not counted
  };
  struct Ended {
    Ticket ticket = 0;
    int status = 0;     // 0, or a negative errno as the system reports it
    std::string bytes;  // that came in
    std::size_t sent = 0;
  };

  explicit UsbHost(UsbDouble* device) : device_(device) {}

  // All return 0, or the errno of the refusal; ENODEV once the device is out.
  int Claim(Program program, unsigned interface, bool drop_system_driver);
  int Release(Program program, unsigned interface);
  int ReleaseAll(Program program);
  int DetachSystemDriver(unsigned interface);
  int AttachSystemDriver(unsigned interface);
  // Who has hold of it: "usbtmc", "usbfs" for a program, or nobody.
  std::string DriverOf(unsigned interface) const;
  int ClearHalt(std::uint8_t endpoint);
  int Reset();

  int Submit(Program program, Ticket ticket, Transfer transfer);
  int Cancel(Ticket ticket);
  // One of the program's transfers that has come to its end; EAGAIN: none has.
  int Reap(Program program, Ended* ended);

  void TakeOut();  // unplugs: what is under way ends
  bool is_out() const;

 private:
  struct UnderWay {
    Program program;
    Ticket ticket;
    Transfer transfer;
    std::optional<Ended> ended;
  };

  void Try(UnderWay* transfer);
  UsbOutcome Control(const Transfer& transfer);
  bool MayUse(Program program, const Transfer& transfer) const;

  UsbDouble* const device_;
  mutable std::mutex mutex_;
  std::list<UnderWay> under_way_;
  Program owner_ = nullptr;  // of the instrument's interface
  bool system_driver_ = true;
  bool out_ = false;
};

}  // namespace gonio
