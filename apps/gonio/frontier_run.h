// SPDX-License-Identifier: Apache-2.0
// Does a frontier study's tasks over the cores, and remembers what is done.

#pragma once

#include <filesystem>
#include <stop_token>

#include "apps/gonio/frontier_config.h"
#include "apps/gonio/frontier_folds.h"
#include "apps/gonio/frontier_result.h"
#include "apps/gonio/progress.h"
#include "apps/gonio/study_run.h"

namespace gonio {

struct FrontierStopTokens {
  std::stop_token after_task;  // finish the tasks in hand
  std::stop_token now;         // drop the sessions in hand
};

// First what is learned from each fold's training materials and the dense fits, then the sessions:
// material x contestant x noise x seed. What an earlier run left in `dir` is not done again. What
// goes wrong in a task is its cell's failure. Cells come in the study's order and, CPU times apart,
// do not depend on the number of threads. Throws ConfigError, before anything is done, if a plan
// brings a prior that has seen a material that is scored; std::runtime_error if a result cannot be
// written.
FrontierResult RunFrontier(const FrontierConfig& study,
                           const std::vector<FrontierMaterial>& materials,
                           const std::filesystem::path& dir, int threads, ProgressLine& line,
                           const FrontierStopTokens& stop, StudyProgress* progress);

}  // namespace gonio
