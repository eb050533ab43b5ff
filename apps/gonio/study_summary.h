// SPDX-License-Identifier: Apache-2.0
// What a study says about thinning, method by method.

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/gonio/study_result.h"

namespace gonio {

// The question of the paper: does the error stay within this factor of the full density's down to
// 30 % of it?
inline constexpr double kHoldsWithin = 1.1;
inline constexpr double kHoldsDownTo = 0.3;

// One material's error against density, mean over its colours; NaN where a colour failed.
struct ThinningCurve {
  std::string material;
  std::vector<double> error;  // one for each of the study's keep_every
  double worst_ratio = 0;     // error / error at full density, the largest down to kHoldsDownTo
  int fails_at = 0;           // the first keep_every, of all, beyond kHoldsWithin; 0: none
};

struct MetricSummary {
  std::string metric;          // "MALE", "MSE"
  std::vector<double> median;  // over the materials, for each keep_every
  std::vector<double> mean;
  std::vector<int> within;  // how many materials are within kHoldsWithin of their full density
  int holds = 0;            // and how many at every density down to kHoldsDownTo
  std::vector<ThinningCurve> curves;  // of the materials that were fitted at full density
};

struct MethodSummary {
  std::string method;
  std::vector<int> keep_every;  // ascending
  MetricSummary male, mse;
};

// One for each method, in the study's order. Without full density (keep_every 1) there are no
// ratios: `within` and `holds` are 0.
std::vector<MethodSummary> Summarise(const StudyResult& study);

nlohmann::json ToJson(const MethodSummary& summary);
void Print(const MethodSummary& summary);

}  // namespace gonio
