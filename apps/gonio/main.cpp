// SPDX-License-Identifier: Apache-2.0
// gonio: every error is one line on standard error and an exit code (commands.h); below that of a
// device, what last went over its wire.

#include <csignal>
#include <cstdio>
#include <exception>
#include <string>

#include "apps/gonio/cli.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/device_error.h"
#include "core/error.h"

namespace {

int Report(int code, std::string message) {
  for (char& c : message) {
    if (c == '\n') c = ' ';
  }
  std::fprintf(stderr, "gonio: %s\n", message.c_str());
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  // A file size limit and a closed pipe are reported like a full disk, instead of killing us with
  // the arms moving.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  try {
    const int code = gonio::RunCommandLine(argc, argv);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
      return Report(gonio::kFailed, "standard output: cannot write");
    }
    return code;
  } catch (const gonio::DeviceError& e) {
    const int code = Report(gonio::kDeviceFaultExit, e.what());
    std::fputs(e.wires().c_str(), stderr);
    return code;
  } catch (const gonio::ConfigError& e) {
    return Report(gonio::kUsage, e.what());
  } catch (const std::exception& e) {
    return Report(gonio::kFailed, e.what());
  }
}
