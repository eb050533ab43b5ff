// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/interrupt.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <semaphore>
#include <thread>

namespace gonio {
namespace {

// Whether `token` was, or within ten seconds is, asked to stop.
bool Stops(const std::stop_token& token) {
  std::binary_semaphore stopped(0);
  const std::stop_callback wake(token, [&] { stopped.release(); });
  return stopped.try_acquire_for(std::chrono::seconds(10));
}

// A keyboard: what is written to `end` is typed.
struct Keyboard {
  Keyboard() { EXPECT_EQ(::pipe(ends.data()), 0); }
  ~Keyboard() {
    ::close(ends[0]);
    if (ends[1] >= 0) ::close(ends[1]);
  }
  void Enter() const { EXPECT_EQ(::write(ends[1], "\n", 1), 1); }
  void Unplug() {
    ::close(ends[1]);
    ends[1] = -1;
  }
  std::array<int, 2> ends{};
};

// Whether it pauses within ten seconds.
bool Pauses(const Interrupt& interrupt) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (!interrupt.pausing() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  return interrupt.pausing();
}

TEST(Interrupt, WithoutATerminalTheFirstSignalAsksAndTheSecondInsists) {
  const Interrupt interrupt;
  EXPECT_FALSE(interrupt.after_pose().stop_requested());
  std::raise(SIGINT);
  EXPECT_TRUE(Stops(interrupt.after_pose()));
  EXPECT_FALSE(interrupt.now().stop_requested());
  EXPECT_FALSE(interrupt.pausing());
  std::raise(SIGTERM);
  EXPECT_TRUE(Stops(interrupt.now()));
}

TEST(Interrupt, AtATerminalTheFirstPausesAndEnterGoesOn) {
  const Keyboard keyboard;
  Interrupt interrupt(keyboard.ends[0]);
  for (int again = 0; again < 2; ++again) {
    std::raise(SIGINT);
    ASSERT_TRUE(Pauses(interrupt));
    keyboard.Enter();
    interrupt.WaitWhilePaused();
    EXPECT_FALSE(interrupt.pausing());
    EXPECT_FALSE(interrupt.after_pose().stop_requested());
  }
  std::raise(SIGINT);
  ASSERT_TRUE(Pauses(interrupt));
  std::raise(SIGINT);
  EXPECT_TRUE(Stops(interrupt.now()));
  interrupt.WaitWhilePaused();  // returns: there is nothing to wait for
}

TEST(Interrupt, ASignalEndsAPause) {
  const Keyboard keyboard;
  Interrupt interrupt(keyboard.ends[0]);
  std::raise(SIGINT);
  ASSERT_TRUE(Pauses(interrupt));
  std::jthread waits([&] { interrupt.WaitWhilePaused(); });
  while (interrupt.pausing()) std::this_thread::yield();
  std::raise(SIGINT);
  waits.join();
  EXPECT_TRUE(interrupt.after_pose().stop_requested());
  EXPECT_FALSE(interrupt.now().stop_requested());
}

TEST(Interrupt, AKeyboardThatIsGoneEndsAPause) {
  Keyboard keyboard;
  Interrupt interrupt(keyboard.ends[0]);
  std::raise(SIGINT);
  ASSERT_TRUE(Pauses(interrupt));
  keyboard.Unplug();
  interrupt.WaitWhilePaused();
  EXPECT_TRUE(interrupt.after_pose().stop_requested());
}

// Where nobody is at a keyboard a session that wants a person waits for a signal.
TEST(Interrupt, SigusrGoesOnWithoutATerminal) {
  Interrupt interrupt;
  std::raise(SIGUSR1);  // nothing is paused: it means nothing
  std::atomic<bool> over = false;
  std::jthread waits([&] {
    interrupt.WaitWhilePaused();
    over = true;
  });
  while (!over) {
    std::raise(SIGUSR1);
    std::this_thread::yield();
  }
  EXPECT_FALSE(interrupt.after_pose().stop_requested());
  std::jthread ends([&] { interrupt.WaitWhilePaused(); });
  std::raise(SIGTERM);
  ends.join();
  EXPECT_TRUE(interrupt.after_pose().stop_requested());
}

TEST(Interrupt, SigtermAndSighupNeverPause) {
  for (const int signal : {SIGTERM, SIGHUP}) {
    const Keyboard keyboard;
    const Interrupt interrupt(keyboard.ends[0]);
    std::raise(signal);
    EXPECT_TRUE(Stops(interrupt.after_pose())) << signal;
    EXPECT_FALSE(interrupt.pausing());
  }
}

TEST(InterruptDeathTest, TheThirdSignalEndsTheProcess) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto raise_three = [] {
    const Interrupt interrupt;
    std::raise(SIGINT);
    Stops(interrupt.after_pose());
    std::raise(SIGINT);
    Stops(interrupt.now());
    std::raise(SIGINT);
    for (;;) ::pause();
  };
  EXPECT_EXIT(raise_three(), testing::ExitedWithCode(128 + SIGINT), "stopping the arms");
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
