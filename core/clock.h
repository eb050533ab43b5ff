// SPDX-License-Identifier: Apache-2.0
// Time is injected: a session reads and waits on a Clock, so that a simulated night takes seconds.

#pragma once

#include <atomic>
#include <chrono>
#include <stop_token>

namespace gonio {

using Seconds = std::chrono::duration<double>;

// Monotonic time since the clock was made. One thread at a time, except that a stop_token may be
// triggered from anywhere.
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
  explicit SystemClock(double rate = 1) : rate_(rate) {}
  Seconds Now() const override { return rate_ * (std::chrono::steady_clock::now() - start_); }
  void SleepFor(Seconds duration, std::stop_token stop = {}) override;

 private:
  const double rate_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Moves only when told to or slept on. Any thread: simulated machines look at it from their own.
class ManualClock final : public Clock {
 public:
  Seconds Now() const override { return Seconds(now_.load()); }
  void SleepFor(Seconds duration, std::stop_token stop = {}) override {
    if (!stop.stop_requested() && duration > Seconds::zero()) now_ += duration.count();
  }

 private:
  std::atomic<double> now_{0};  // s
};

}  // namespace gonio
