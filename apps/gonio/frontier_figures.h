// SPDX-License-Identifier: Apache-2.0
// Pictures of a frontier study.

#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "apps/gonio/frontier_result.h"
#include "apps/gonio/frontier_summary.h"
#include "apps/gonio/plot.h"

namespace gonio {

enum class Cost { kPoses, kMinutes };

// Error against what it cost, log-log, a panel for each noise and group of materials: the median
// of each contestant and of the dense fit. Contestants whose reconstruction gives intervals, the
// processes, are on top and thicker, with a band from the first to the third quartile.
Plot FrontierPlot(const FrontierResult& result, const std::vector<ContestantSummary>& summaries,
                  Cost cost);

// Coverage of the 90 % intervals at the largest budget, material by material, mean over the seeds,
// a panel for each noise and group of materials. Empty without intervals.
std::optional<Plot> CoveragePlot(const FrontierResult& result);

// True against predicted error, a point for each session and budget. Empty without predictions.
std::optional<Plot> PredictedErrorPlot(const FrontierResult& result);

// All of these in `dir`, each as .svg and .png.
void WriteFrontierFigures(const std::filesystem::path& dir, const FrontierResult& result,
                          const std::vector<ContestantSummary>& summaries);

}  // namespace gonio
