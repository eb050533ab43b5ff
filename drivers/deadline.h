// SPDX-License-Identifier: Apache-2.0
// How much longer a device may take to answer, in real time.

#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/clock.h"

namespace gonio {

class Deadline {
 public:
  explicit Deadline(Seconds limit)
      : limit_(limit),
        end_(std::chrono::steady_clock::now() +
             std::chrono::duration_cast<std::chrono::steady_clock::duration>(limit)) {}

  Seconds limit() const { return limit_; }
  Seconds Left() const {  // >= 0
    return std::max(Seconds(end_ - std::chrono::steady_clock::now()), Seconds(0));
  }
  // Rounded up, so that no fraction of a millisecond is spent polling.
  int MillisecondsLeft() const { return static_cast<int>(std::ceil(1000 * Left().count())); }

 private:
  Seconds limit_;
  std::chrono::steady_clock::time_point end_;
};

}  // namespace gonio
