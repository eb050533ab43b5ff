// SPDX-License-Identifier: Apache-2.0
#include "sim/pty.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>

#include "core/error.h"

namespace gonio {

Pty::Pty() : controller_(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
  char path[64] = {};
  termios settings = {};
  if (controller_ < 0 || grantpt(controller_) != 0 || unlockpt(controller_) != 0 ||
      ptsname_r(controller_, path, sizeof path) != 0 || tcgetattr(controller_, &settings) != 0) {
    const std::string why = std::strerror(errno);
    HangUp();
    throw ConfigError(fmt::format("no pseudo-terminal to be had: {}", why));
  }
  path_ = path;
  kept_open_ = open(path, O_RDWR | O_NOCTTY | O_CLOEXEC);
  cfmakeraw(&settings);  // else what we send before a program opens it would be echoed to us
  tcsetattr(controller_, TCSANOW, &settings);
}

Pty::~Pty() { HangUp(); }

void Pty::Send(std::string_view bytes) {
  while (controller_ >= 0 && !bytes.empty()) {
    const ssize_t count = write(controller_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

std::string Pty::Receive(Seconds limit) {
  pollfd ready{.fd = controller_, .events = POLLIN, .revents = 0};
  const int milliseconds = static_cast<int>(std::ceil(1000 * limit.count()));
  if (poll(&ready, 1, milliseconds) <= 0 || (ready.revents & POLLIN) == 0) return {};
  char bytes[4096];
  const ssize_t count = read(controller_, bytes, sizeof bytes);
  return count > 0 ? std::string(bytes, static_cast<std::size_t>(count)) : std::string();
}

void Pty::HangUp() {
  if (controller_ >= 0) close(controller_);
  if (kept_open_ >= 0) close(kept_open_);
  controller_ = kept_open_ = -1;
}

}  // namespace gonio
