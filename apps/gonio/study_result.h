// SPDX-License-Identifier: Apache-2.0
// A study's results on disk: what `gonio study` leaves and `gonio plot` draws.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "brdf/metrics.h"

namespace gonio {

// One colour of one material, fitted by one method at one thinning.
struct StudyCell {
  std::string material;
  std::string method;  // "em", "joint", "continuous"
  int keep_every = 1;  // density is 1 / keep_every
  int channel = 0;
  std::string failure;  // empty: fitted, and the numbers below hold
  double male = 0;
  double mse = 0;  // over the whole table, as in the paper
  double log_relative_rms = 0, cube_root_rms = 0, log_mse = 0;
};

struct StudyResult {
  std::string name;
  std::vector<StudyCell> cells;  // by material, method, keep_every, channel, in the study's order
};

// Whether `dir` holds a study.
bool IsStudyFolder(const std::filesystem::path& dir);
// What has been done so far. Throws ConfigError "DIR: ...".
StudyResult ReadStudy(const std::filesystem::path& dir);

}  // namespace gonio
