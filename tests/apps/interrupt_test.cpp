// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/interrupt.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <semaphore>

namespace gonio {
namespace {

// Whether `token` was, or within ten seconds is, asked to stop.
bool Stops(const std::stop_token& token) {
  std::binary_semaphore stopped(0);
  const std::stop_callback wake(token, [&] { stopped.release(); });
  return stopped.try_acquire_for(std::chrono::seconds(10));
}

TEST(Interrupt, TheFirstSignalAsksAndTheSecondInsists) {
  const Interrupt interrupt;
  EXPECT_FALSE(interrupt.after_pose().stop_requested());
  std::raise(SIGINT);
  EXPECT_TRUE(Stops(interrupt.after_pose()));
  EXPECT_FALSE(interrupt.now().stop_requested());
  std::raise(SIGTERM);
  EXPECT_TRUE(Stops(interrupt.now()));
  std::raise(SIGINT);  // a third changes nothing
}

TEST(Interrupt, GivesTheSignalsBackAndCanBeMadeAgain) {
  for (int i = 0; i < 3; ++i) {
    const Interrupt interrupt;
    EXPECT_FALSE(interrupt.after_pose().stop_requested());
    if (i == 1) std::raise(SIGINT);
  }
  struct sigaction action {};
  sigaction(SIGINT, nullptr, &action);
  EXPECT_EQ(action.sa_handler, SIG_DFL);
}

}  // namespace
}  // namespace gonio
