// SPDX-License-Identifier: Apache-2.0
// What a frontier study finds out, and its files.

#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace gonio {

// The intervals whose coverage is counted.
inline constexpr std::array<double, 3> kIntervals = {0.5, 0.9, 0.95};
inline constexpr int kNinety = 1;  // index of the 90 % interval

// A reconstruction from the first poses of a session.
struct FrontierRow {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  int budget = 0;
  int poses = 0;              // fewer than the budget where the planner had enough before
  double minutes = kUnknown;  // session clock at the last of them, homing included
  double male = kUnknown, log_relative_rms = kUnknown, mse = kUnknown, cube_root_rms = kUnknown,
         log_mse = kUnknown;          // brdf/metrics.h
  double predicted_error = kUnknown;  // the planner's; unknown if it has none
  // Share of the directions (uniform in angle, none of them measured) and channels whose true f_r
  // lies in the interval of kIntervals; unknown if the reconstruction gives no intervals.
  std::array<double, 3> coverage = {kUnknown, kUnknown, kUnknown};
  std::string failure{};  // empty: reconstructed
};

// Where a session would have ended had it been told to stop at a predicted error.
struct FrontierStop {
  double target = 0;
  int poses = 0;  // 0: the predicted error never got there
  double minutes = FrontierRow::kUnknown;
  double male = FrontierRow::kUnknown;  // the true error there
};

// One task: a contestant on a material.
struct FrontierCell {
  std::string material, contestant, noise;
  std::uint64_t seed = 0;
  bool held_out = false;
  int fold = 0;
  std::string failure{};  // empty: there is a row for each budget
  std::vector<FrontierRow> rows{};
  std::vector<FrontierStop> stops{};
  // CPU seconds: the sessions with their planner, reconstructions, metrics and coverage.
  double session_s = 0, reconstruction_s = 0, scoring_s = 0;
};

// One material measured densely, without noise.
struct DenseCell {
  std::string material;
  bool held_out = false;
  std::string failure;
  double male = FrontierRow::kUnknown;
};

struct FrontierResult {
  std::string name, rig, dense_method;
  double dense_hours = 0, thinned_hours = 0;  // on this rig, estimated
  int dense_poses = 0, thinned_poses = 0;
  std::vector<DenseCell> dense;     // by material
  std::vector<FrontierCell> cells;  // by material, contestant, noise, seed, in the study's order
};

// One task's outcome in a file of its own, with `key`, a hash of all it depends on. Reading gives
// nothing if there is no such file, it is torn, or it was made from something else.
void WriteFrontierCell(const std::filesystem::path& path, const std::string& key,
                       const FrontierCell& cell);
std::optional<FrontierCell> ReadFrontierCell(const std::filesystem::path& path,
                                             const std::string& key);
void WriteDenseCell(const std::filesystem::path& path, const std::string& key,
                    const DenseCell& cell);
std::optional<DenseCell> ReadDenseCell(const std::filesystem::path& path, const std::string& key);

// DIR/results.csv: a row for each material x contestant x seed x noise x budget.
void WriteFrontierCsv(const std::filesystem::path& path, const FrontierResult& result);

}  // namespace gonio
