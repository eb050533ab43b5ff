// SPDX-License-Identifier: Apache-2.0
// How many poses and hours a plan takes to an error, over materials and seeds.

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/gonio/simulate_session.h"

namespace gonio {

// Median and 80 % interval; infinite where so many sessions never got there. NaN: no numbers.
struct Spread {
  double median = 0;
  double low = 0;   // 10 % quantile
  double high = 0;  // 90 %
};
Spread SpreadOf(const std::vector<double>& numbers);
// "23 (15 to 41)", with `decimals`; "never" for what is infinite, "-" for NaN.
std::string ToText(const Spread& spread, int decimals);

// When one kind of error reached the target.
struct Attained {
  int sessions = 0;  // that did
  Spread poses;
  Spread hours;
};

struct Answer {
  std::string plan;
  int sessions = 0;
  Attained by_predicted;
  Attained by_true;
  Spread male_at_stop;  // of the sessions that would have stopped
};

// One for each plan, in the order of the sessions. A session that never got there took infinitely
// many poses.
std::vector<Answer> AnswersOf(const std::vector<SimulatedSession>& sessions);

// Shares are 0 .. 1; what is infinite or unknown is null.
nlohmann::json ToJson(const Answer& answer);

// What a plan is compared with.
struct Scans {
  double dense_hours = 0;
  double thinned_hours = 0;
};
void PrintAnswers(const std::vector<Answer>& answers, double target, const Scans& scans);

}  // namespace gonio
