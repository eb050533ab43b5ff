// SPDX-License-Identifier: Apache-2.0
// The control channel of a GigE Vision camera (GVCP): its registers over UDP.

#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace gonio {

class GigeMemory;

// Called by the channel's thread.
struct GigeControlHooks {
  std::function<void(std::uint32_t address)> written;  // a client has written this register
  std::function<void()> abandoned;                     // the one in control has left or died
  // Packets first to last of a frame are wanted once more.
  std::function<void(std::uint16_t frame, std::uint32_t first, std::uint32_t last)> resend;
};

// Answers searches (broadcasts that reach this machine, too), and reads by anybody. Writes are of
// the one client that has taken control, until it gives it back or is not heard for as long as its
// heartbeat allows; other writes are answered with "access denied".
class GigeControl {
 public:
  static constexpr std::uint16_t kPort = 3956;

  // Serves until it is destroyed. `memory` must outlive it.
  GigeControl(const std::string& address, GigeMemory& memory, GigeControlHooks hooks);
  ~GigeControl();
  // Whether the address is an interface's, and its port was free.
  bool ok() const;

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace gonio
