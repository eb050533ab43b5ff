// SPDX-License-Identifier: Apache-2.0
// A controller emulated at the end of a line, and what drivers are opened with in tests.

#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "drivers/controller_axis.h"
#include "drivers/serial_port.h"
#include "sim/pty_server.h"

namespace gonio {

// Until a reply is missed. Long: a busy machine may keep the emulator waiting.
inline constexpr Seconds kWireReplyLimit{0.5};

inline std::unique_ptr<SerialPort> OpenedPort(const PtyServer& line, SerialSettings settings = {}) {
  settings.port = line.path();
  auto port = SerialPort::Open(settings);
  EXPECT_TRUE(port.ok()) << port.error().message;
  return std::move(port).value();
}

// Everything a double was sent. Any thread.
class Heard {
 public:
  void Add(std::string_view bytes) {
    const std::lock_guard lock(mutex_);
    bytes_ += bytes;
  }
  std::string Text() const {
    const std::lock_guard lock(mutex_);
    return bytes_;
  }
  void Clear() {
    const std::lock_guard lock(mutex_);
    bytes_.clear();
  }

 private:
  mutable std::mutex mutex_;
  std::string bytes_;
};

inline ControllerAxisSettings ArmSettings() {
  ControllerAxisSettings settings;
  settings.name = "arm";
  settings.limits = {.min_position = -2,
                     .max_position = 2.5,
                     .max_speed = 0.5,
                     .acceleration = 1,
                     .position_tolerance = 1e-4};
  return settings;
}

}  // namespace gonio
