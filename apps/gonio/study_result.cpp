// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/study_result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "apps/gonio/csv_text.h"
#include "apps/gonio/json_file.h"
#include "apps/gonio/study_summary.h"
#include "brdf/brdf.h"
#include "core/error.h"
#include "core/file.h"

namespace gonio {
namespace {

using nlohmann::json;

struct Quantity {
  const char* json_name;
  const char* csv_name;
  double StudyCell::*number;
};
constexpr Quantity kQuantities[] = {
    {"male", "male", &StudyCell::male},
    {"table_mse", "table_mse_per_sr2", &StudyCell::table_mse},
    {"log_relative_rms", "log_relative_rms", &StudyCell::log_relative_rms},
    {"mse", "mse_per_sr2", &StudyCell::mse},
    {"cube_root_rms", "cube_root_rms", &StudyCell::cube_root_rms},
    {"log_mse", "log_mse", &StudyCell::log_mse},
};

json ToJson(const StudyCell& cell) {
  json entry = {{"material", cell.material},
                {"method", cell.method},
                {"keep_every", cell.keep_every},
                {"colour", kChannelNames[cell.channel]}};
  if (!cell.warning.empty()) entry["warning"] = cell.warning;
  if (!cell.failure.empty()) {
    entry["failure"] = cell.failure;
    return entry;
  }
  for (const Quantity& quantity : kQuantities) {
    const double number = cell.*quantity.number;
    entry[quantity.json_name] = std::isfinite(number) ? json(number) : json(nullptr);
  }
  return entry;
}

StudyCell ToCell(const json& entry) {
  StudyCell cell;
  cell.material = entry.at("material");
  cell.method = entry.at("method");
  cell.keep_every = entry.at("keep_every");
  const auto* colour = std::find(std::begin(kChannelNames), std::end(kChannelNames),
                                 entry.at("colour").get<std::string>());
  if (colour == std::end(kChannelNames)) throw std::runtime_error("unknown colour");
  cell.channel = static_cast<int>(colour - std::begin(kChannelNames));
  cell.warning = entry.value("warning", "");
  cell.failure = entry.value("failure", "");
  if (!cell.failure.empty()) return cell;
  for (const Quantity& quantity : kQuantities) {
    const json& number = entry.at(quantity.json_name);
    if (!number.is_null()) cell.*quantity.number = number.get<double>();
  }
  return cell;
}

json ToJson(const std::vector<StudyCell>& cells) {
  json list = json::array();
  for (const StudyCell& cell : cells) list.push_back(ToJson(cell));
  return list;
}

std::vector<StudyCell> ToCells(const json& list) {
  std::vector<StudyCell> cells;
  for (const json& entry : list) cells.push_back(ToCell(entry));
  return cells;
}

void WriteCsv(const std::filesystem::path& path, const StudyResult& study) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "material,method,keep_every,density_percent,colour";
    for (const Quantity& quantity : kQuantities) out << ',' << quantity.csv_name;
    out << ",failure,warning\n";
    for (const StudyCell& cell : study.cells) {
      out << fmt::format("{},{},{},{:.4g},{}", CsvText(cell.material), cell.method, cell.keep_every,
                         100.0 / cell.keep_every, kChannelNames[cell.channel]);
      for (const Quantity& quantity : kQuantities) {
        const double number = cell.*quantity.number;
        out << ',' << (std::isfinite(number) ? fmt::format("{:.9g}", number) : "");
      }
      out << ',' << CsvText(cell.failure) << ',' << CsvText(cell.warning) << '\n';
    }
  });
}

}  // namespace

void WriteCells(const std::filesystem::path& path, const std::string& key,
                const std::vector<StudyCell>& cells) {
  std::filesystem::create_directories(path.parent_path());
  WriteJson(path, {{"key", key}, {"cells", ToJson(cells)}});
}

std::optional<std::vector<StudyCell>> ReadCells(const std::filesystem::path& path,
                                                const std::string& key) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  try {
    const json file = json::parse(ReadTextFile(path));
    if (file.at("key") != key) return std::nullopt;
    return ToCells(file.at("cells"));
  } catch (const std::exception&) {
    return std::nullopt;  // torn or tampered with: done again
  }
}

void WriteStudy(const std::filesystem::path& dir, const StudyResult& study) {
  WriteCsv(dir / "cells.csv", study);
  json summaries = json::array();
  for (const MethodSummary& summary : Summarise(study)) summaries.push_back(ToJson(summary));
  WriteJson(dir / kStudyFile, {{"gonio_version", GONIO_VERSION},
                               {"format", "gonio-study"},
                               {"version", 1},
                               {"name", study.name},
                               {"summary", summaries},
                               {"cells", ToJson(study.cells)}});
}

bool IsStudyFolder(const std::filesystem::path& dir) {
  return std::filesystem::exists(dir / kStudyFile);
}

StudyResult ReadStudy(const std::filesystem::path& dir) {
  const std::filesystem::path path = dir / kStudyFile;
  if (!IsStudyFolder(dir)) throw ConfigError(dir.string() + ": holds no " + kStudyFile);
  try {
    const json file = json::parse(ReadTextFile(path));
    if (file.at("format") != "gonio-study" || file.at("version") != 1) {
      throw ConfigError(path.string() + ": is no study of version 1");
    }
    return {file.at("name"), ToCells(file.at("cells"))};
  } catch (const json::exception& e) {
    throw ConfigError(fmt::format("{}: {}", path.string(), e.what()));
  }
}

}  // namespace gonio
