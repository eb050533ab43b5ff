// SPDX-License-Identifier: Apache-2.0
#include "core/clock.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <utility>

namespace gonio {

void SystemClock::SleepFor(Seconds duration, std::stop_token stop) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any condition;
  condition.wait_for(lock, stop, duration / rate_, [] { return false; });
}

void WatchedClock::Watch(Seconds interval, std::function<void()> look) {
  interval_ = interval;
  look_ = std::move(look);
  watched_ = look_ ? std::this_thread::get_id() : std::thread::id();
}

void WatchedClock::SleepFor(Seconds duration, std::stop_token stop) {
  if (watched_.load() != std::this_thread::get_id() || looking_) {
    clock_->SleepFor(duration, std::move(stop));
    return;
  }
  const Seconds end = clock_->Now() + duration;
  for (Seconds left = duration; left > Seconds(0); left = end - clock_->Now()) {
    clock_->SleepFor(std::min(left, interval_), stop);
    looking_ = true;
    look_();
    looking_ = false;
    if (stop.stop_requested()) return;
  }
}

}  // namespace gonio
