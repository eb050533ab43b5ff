// SPDX-License-Identifier: Apache-2.0
// A study's results on disk: what `gonio study` leaves and `gonio plot` draws.

#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace gonio {

// One colour of one material, fitted by one method at one thinning.
struct StudyCell {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  std::string material;
  std::string method;  // "em", "joint", "continuous"
  int keep_every = 1;  // density is 1 / keep_every
  int channel = 0;
  std::string failure;  // empty: fitted, and the numbers below hold
  std::string warning;  // empty: nothing to remark
  double male = kUnknown;
  double table_mse = kUnknown;  // over the whole table, as in the paper, 1/sr^2
  double mse = kUnknown, log_relative_rms = kUnknown, cube_root_rms = kUnknown, log_mse = kUnknown;
};

struct StudyResult {
  std::string name;
  std::vector<StudyCell> cells;  // by material, method, keep_every, channel, in the study's order
};

// One task's cells, one for each colour, in a file of their own: written when they are done, whole,
// with `key`, a hash of all they depend on.
void WriteCells(const std::filesystem::path& path, const std::string& key,
                const std::vector<StudyCell>& cells);
// Empty if there is no such file, it is torn, or it was made from something else (another key).
std::optional<std::vector<StudyCell>> ReadCells(const std::filesystem::path& path,
                                                const std::string& key);

// DIR/study.json and DIR/cells.csv, from which everything is read back.
inline constexpr const char* kStudyFile = "study.json";
void WriteStudy(const std::filesystem::path& dir, const StudyResult& study);

// Whether `dir` holds a study.
bool IsStudyFolder(const std::filesystem::path& dir);
// What has been done so far. Throws ConfigError "DIR: ...".
StudyResult ReadStudy(const std::filesystem::path& dir);

}  // namespace gonio
