// SPDX-License-Identifier: Apache-2.0
// Runs these tests where benches are seen (sim/usb_bench.h): starts itself again with umockdev
// loaded before everything else. 77: there is none, which ctest counts as skipped.
#include <gmock/gmock.h>
#include <stdlib.h>
#include <unistd.h>

#include <cstdio>
#include <string>

#include "sim/usb_bench.h"

namespace {

constexpr int kSkipped = 77;
constexpr const char* kTried = "GONIO_TESTS_STARTED_AGAIN";

// Does not return if it can.
void StartAgain(char** argv) {
  const char* const before = getenv("LD_PRELOAD");
  const std::string preload =
      std::string(gonio::UsbBench::kPreload) + (before == nullptr ? "" : std::string(":") + before);
  setenv("LD_PRELOAD", preload.c_str(), 1);
  setenv(kTried, "1", 1);
  // Sanitizers want to be first themselves.
  const char* const options = getenv("ASAN_OPTIONS");
  const std::string asan =
      (options == nullptr ? "" : std::string(options) + ":") + "verify_asan_link_order=0";
  setenv("ASAN_OPTIONS", asan.c_str(), 1);
  execv("/proc/self/exe", argv);
}

// A library that cannot be preloaded is passed over with a warning.
bool IsLoaded() {
  std::FILE* const maps = std::fopen("/proc/self/maps", "r");
  if (maps == nullptr) return false;
  bool loaded = false;
  char line[4096];
  while (!loaded && std::fgets(line, sizeof line, maps) != nullptr) {
    loaded = std::string(line).find("libumockdev-preload") != std::string::npos;
  }
  std::fclose(maps);
  return loaded;
}

}  // namespace

int main(int argc, char** argv) {
  if (!gonio::UsbBench::SeenFromHere() && getenv(kTried) == nullptr) StartAgain(argv);
  if (!IsLoaded()) {
    std::fprintf(stderr, "%s is not installed: skipped\n", gonio::UsbBench::kPreload);
    return kSkipped;
  }
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
