// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_result.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/gonio/csv_text.h"
#include "apps/gonio/frontier_json.h"
#include "apps/gonio/json_file.h"
#include "core/file.h"

namespace gonio {
namespace {

using nlohmann::json;

json ToJson(const std::string& key, const json& cell) { return {{"key", key}, {"cell", cell}}; }

void WriteCell(const std::filesystem::path& path, const std::string& key, const json& cell) {
  std::filesystem::create_directories(path.parent_path());
  WriteJson(path, ToJson(key, cell));
}

template <typename Cell, typename FromJson>
std::optional<Cell> ReadCell(const std::filesystem::path& path, const std::string& key,
                             const FromJson& from_json) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  try {
    const json file = json::parse(ReadTextFile(path));
    if (file.at("key") != key) return std::nullopt;
    return from_json(file.at("cell"));
  } catch (const std::exception&) {
    return std::nullopt;  // torn or tampered with: done again
  }
}

std::string CsvNumber(double number) {
  return std::isfinite(number) ? fmt::format("{:.9g}", number) : "";
}

std::string CsvRow(const FrontierCell& cell, const FrontierRow& row) {
  std::string line =
      fmt::format("{},{},{},{},{},{},{},{},{}", CsvText(cell.material), cell.contestant, cell.noise,
                  cell.seed, cell.held_out ? "held_out" : "materials", cell.fold, row.budget,
                  row.poses, CsvNumber(row.minutes));
  for (const double number :
       {row.male, row.log_relative_rms, row.mse, row.cube_root_rms, row.log_mse,
        row.predicted_error, row.coverage[0], row.coverage[1], row.coverage[2]}) {
    line += ',' + CsvNumber(number);
  }
  return line + ',' + CsvText(cell.failure.empty() ? row.failure : cell.failure) + '\n';
}

}  // namespace

void WriteFrontierCell(const std::filesystem::path& path, const std::string& key,
                       const FrontierCell& cell) {
  WriteCell(path, key, ToJson(cell));
}

std::optional<FrontierCell> ReadFrontierCell(const std::filesystem::path& path,
                                             const std::string& key) {
  return ReadCell<FrontierCell>(path, key, FrontierCellFromJson);
}

void WriteDenseCell(const std::filesystem::path& path, const std::string& key,
                    const DenseCell& cell) {
  WriteCell(path, key, ToJson(cell));
}

std::optional<DenseCell> ReadDenseCell(const std::filesystem::path& path, const std::string& key) {
  return ReadCell<DenseCell>(path, key, DenseCellFromJson);
}

void WriteFrontierCsv(const std::filesystem::path& path, const FrontierResult& result) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "material,contestant,noise,seed,group,fold,budget,poses,minutes,male,log_relative_rms,"
           "mse_per_sr2,cube_root_rms,log_mse,predicted_error,coverage_50,coverage_90,coverage_95,"
           "failure\n";
    for (const FrontierCell& cell : result.cells) {
      for (const FrontierRow& row : cell.rows) out << CsvRow(cell, row);
    }
  });
}

}  // namespace gonio
