// SPDX-License-Identifier: Apache-2.0
// Time is injected: a session reads and waits on a Clock, so that a simulated night takes seconds.

#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <stop_token>
#include <thread>

namespace gonio {

using Seconds = std::chrono::duration<double>;

// Monotonic time, by default since the clock was made. One thread at a time, except that a
// stop_token may be triggered from anywhere.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual Seconds Now() const = 0;
  // Returns after `duration`, or early once `stop` is requested. Negative durations count as zero.
  virtual void SleepFor(Seconds duration, std::stop_token stop = {}) = 0;
};

// The machine's, for real devices. Any thread.
class SystemClock final : public Clock {
 public:
  // So many seconds of it pass in one of the machine's: > 1 for doubles in a hurry.
  // Begins at `begin`: a session that is resumed goes on where its log ends.
  explicit SystemClock(double rate = 1, Seconds begin = Seconds(0)) : rate_(rate), begin_(begin) {}
  Seconds Now() const override {
    return begin_ + rate_ * (std::chrono::steady_clock::now() - start_);
  }
  void SleepFor(Seconds duration, std::stop_token stop = {}) override;

 private:
  const double rate_;
  const Seconds begin_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Moves only when told to or slept on. Any thread: simulated machines look at it from their own.
class ManualClock final : public Clock {
 public:
  explicit ManualClock(Seconds begin = Seconds(0)) : now_(begin.count()) {}
  Seconds Now() const override { return Seconds(now_.load()); }
  void SleepFor(Seconds duration, std::stop_token stop = {}) override {
    if (!stop.stop_requested() && duration > Seconds::zero()) now_ += duration.count();
  }

 private:
  std::atomic<double> now_;  // s
};

// A clock on which somebody looks around while one thread sleeps: what waits for a motor waits
// here. Any thread, but for Watch().
class WatchedClock final : public Clock {
 public:
  explicit WatchedClock(std::unique_ptr<Clock> clock) : clock_(std::move(clock)) {}

  // From now on sleeps of the calling thread come in pieces of at most `interval` > 0, with `look`
  // after each; it is not called while it runs. Empty: no more. For the thread that sleeps.
  void Watch(Seconds interval, std::function<void()> look);

  Seconds Now() const override { return clock_->Now(); }
  void SleepFor(Seconds duration, std::stop_token stop = {}) override;

 private:
  const std::unique_ptr<Clock> clock_;
  std::atomic<std::thread::id> watched_{};  // the other members below belong to this thread
  Seconds interval_{0};
  std::function<void()> look_;
  bool looking_ = false;
};

}  // namespace gonio
