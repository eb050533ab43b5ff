// SPDX-License-Identifier: Apache-2.0
// Does a study's tasks over the cores, and remembers what is done.

#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "apps/gonio/progress.h"
#include "apps/gonio/study_config.h"
#include "apps/gonio/study_result.h"

namespace gonio {

struct StudyProgress {
  int tasks = 0;      // material x method x thinning
  int reused = 0;     // done before, by an earlier run
  bool whole = true;  // false: stopped before all were done
};

// Does what is not yet done in `dir`/cells, task by task, on `threads` threads; the tasks that run
// when `stop` is requested are finished. A material that cannot be opened, a colour that cannot be
// fitted and whatever else goes wrong in a task are cells with a `failure`. Cells come in the
// study's order and do not depend on the number of threads. Throws std::runtime_error if a result
// cannot be written.
StudyResult RunStudy(const StudyConfig& study, const std::vector<std::filesystem::path>& materials,
                     const std::filesystem::path& dir, int threads, ProgressLine& line,
                     const std::stop_token& stop, StudyProgress* progress);

}  // namespace gonio
