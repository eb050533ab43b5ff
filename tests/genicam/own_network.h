// SPDX-License-Identifier: Apache-2.0
// A network of their own for programs that need the port of GigE Vision cameras.

#pragma once

#include <fcntl.h>
#include <net/if.h>
#include <sched.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

namespace gonio {

// Whether EnterOwnNetwork() did: then broadcasts go nowhere.
inline bool in_own_network = false;

// Only the loopback interface, which is down at first. Where that is not permitted, tests that
// ctest runs at the same time take turns on the machine's own.
// Before there is a second thread.
inline void EnterOwnNetwork() {
  if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
    flock(open(GONIO_SOURCE_DIR "/CMakeLists.txt", O_RDONLY | O_CLOEXEC), LOCK_EX);
    return;
  }
  in_own_network = true;
  const int any = socket(AF_INET, SOCK_DGRAM, 0);
  ifreq request{};
  request.ifr_name[0] = 'l';
  request.ifr_name[1] = 'o';
  request.ifr_flags = IFF_UP | IFF_RUNNING | IFF_LOOPBACK;
  if (any >= 0) {
    ioctl(any, SIOCSIFFLAGS, &request);
    close(any);
  }
}

}  // namespace gonio
