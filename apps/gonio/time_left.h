// SPDX-License-Identifier: Apache-2.0
// How long the rest will take, and how sure that is.

#pragma once

#include <optional>

#include "core/clock.h"

namespace gonio {

// Of work in steps that take differently long. One thread.
class TimeLeft {
 public:
  // `done` steps are finished at `now`; the first call sets what is counted from.
  void Show(int done, Seconds now);

  struct Interval {
    Seconds expected{0};
    Seconds low{0};  // about 95 % of what will be, if the steps left are like those done
    Seconds high{0};
  };
  // Empty before a step was seen.
  std::optional<Interval> For(int steps) const;

 private:
  bool begun_ = false;
  int done_ = 0;
  Seconds last_{0};
  // Welford's running mean and sum of squares of the seconds of a step.
  int count_ = 0;
  double mean_ = 0;
  double squares_ = 0;
};

}  // namespace gonio
