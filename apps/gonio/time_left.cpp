// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/time_left.h"

#include <algorithm>
#include <cmath>

namespace gonio {

void TimeLeft::Show(int done, Seconds now) {
  if (!begun_) {
    begun_ = true;
  } else if (done > done_) {
    const double step = (now - last_).count() / (done - done_);
    for (; done_ < done; ++done_) {
      ++count_;
      const double off = step - mean_;
      mean_ += off / count_;
      squares_ += off * (step - mean_);
    }
  } else {
    return;  // a step that was refused: its time belongs to the next
  }
  done_ = done;
  last_ = now;
}

std::optional<TimeLeft::Interval> TimeLeft::For(int steps) const {
  if (count_ == 0) return std::nullopt;
  const double expected = steps * mean_;
  // Of one step only its length is known; it may be wrong by itself.
  const double variance = count_ > 1 ? squares_ / (count_ - 1) : mean_ * mean_;
  // Scatter of the steps left, and of the mean that was taken from those done.
  const double sigma = std::sqrt(variance * steps * (1 + static_cast<double>(steps) / count_));
  return Interval{Seconds(expected), Seconds(std::max(0.0, expected - 2 * sigma)),
                  Seconds(expected + 2 * sigma)};
}

}  // namespace gonio
