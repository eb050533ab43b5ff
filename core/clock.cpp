// SPDX-License-Identifier: Apache-2.0
#include "core/clock.h"

#include <condition_variable>
#include <mutex>

namespace gonio {

void SystemClock::SleepFor(Seconds duration, std::stop_token stop) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any condition;
  condition.wait_for(lock, stop, duration / rate_, [] { return false; });
}

}  // namespace gonio
