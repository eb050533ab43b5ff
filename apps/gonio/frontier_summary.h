// SPDX-License-Identifier: Apache-2.0
// What a frontier study says about each contestant.

#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "apps/gonio/frontier_result.h"

namespace gonio {

// A session is as good as the dense scan once its error is at most this many times that of the
// dense DSBRDF fit.
inline constexpr double kAsGoodAsDense = 1.05;
// A material's 90 % intervals are calibrated if they hold this share of the directions.
inline constexpr double kCalibratedFrom = 0.85;
inline constexpr double kCalibratedTo = 0.95;

// Over all materials and seeds of a contestant.
struct BudgetSummary {
  int budget = 0;
  int count = 0;                                           // sessions with a reconstruction
  double mean = 0, median = 0, q25 = 0, q75 = 0, q90 = 0;  // of MALE
  double minutes = 0;                                      // median
  std::array<double, 3> coverage = {};                     // mean; NaN without intervals
  double share_calibrated = 0;                             // of the sessions; NaN without intervals
};

// What it takes to be as good as the dense scan. A session that never is counts as infinite, so
// that a quantile may be infinite, too; materials without a dense fit do not count.
struct Need {
  double median = 0, q90 = 0;
  int never = 0;
  int count = 0;
};

// Sessions told to stop at a predicted error.
struct StopSummary {
  double target = 0;
  int sessions = 0;                         // of planners that predict an error
  int stopped = 0;                          // within the largest budget
  int honest = 0;                           // of those: the true error was at or below the target
  double poses = 0, minutes = 0, male = 0;  // medians of those that stopped
};

struct ContestantSummary {
  std::string contestant, noise;
  bool held_out = false;
  int failed = 0;  // sessions or reconstructions
  std::vector<BudgetSummary> budgets{};
  Need poses{}, minutes{};
  std::vector<StopSummary> stops{};
};

// Cross-validated materials first, then those held out; in each by noise, then in the study's order
// of contestants.
std::vector<ContestantSummary> Summarise(const FrontierResult& result);

// Where the error of a session falls to `error`, interpolated between the budgets on logarithmic
// axes; at the first budget if it is that good there already.
struct Crossing {
  double poses = 0, minutes = 0;
};
std::optional<Crossing> FindCrossing(const std::vector<FrontierRow>& rows, double error);

}  // namespace gonio
