// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "apps/gonio/frontier_figures.h"
#include "apps/gonio/frontier_json.h"
#include "apps/gonio/frontier_report.h"
#include "apps/gonio/frontier_run.h"
#include "apps/gonio/interrupt.h"
#include "apps/gonio/json_file.h"
#include "apps/gonio/study_config.h"
#include "core/file.h"
#include "core/task_pool.h"

namespace gonio {
namespace {

using nlohmann::json;

template <typename Items>
json ToList(const Items& items) {
  json list = json::array();
  for (const auto& item : items) list.push_back(ToJson(item));
  return list;
}

void WriteResults(const std::filesystem::path& dir, const FrontierResult& result,
                  const std::vector<ContestantSummary>& summaries) {
  WriteFrontierCsv(dir / "results.csv", result);
  WriteJson(dir / "results.json", {{"gonio_version", GONIO_VERSION},
                                   {"format", "gonio-frontier"},
                                   {"version", 1},
                                   {"name", result.name},
                                   {"rig", result.rig},
                                   {"dense_method", result.dense_method},
                                   {"dense_poses", result.dense_poses},
                                   {"dense_hours", result.dense_hours},
                                   {"thinned_poses", result.thinned_poses},
                                   {"thinned_hours", result.thinned_hours},
                                   {"dense", ToList(result.dense)},
                                   {"summary", ToList(summaries)},
                                   {"cells", ToList(result.cells)}});
}

// Each failure once for each material and contestant; returns how many tasks failed.
int ListFailures(const FrontierResult& result) {
  std::set<std::string> said;
  int failed = 0;
  const auto say = [&](const std::string& text) {
    if (said.insert(text).second) fmt::print(stderr, "gonio: {}\n", text);
  };
  for (const DenseCell& cell : result.dense) {
    if (cell.failure.empty()) continue;
    ++failed;
    say(fmt::format("{}, dense fit: {}", cell.material, cell.failure));
  }
  for (const FrontierCell& cell : result.cells) {
    bool any = false;
    for (const FrontierRow& row : cell.rows) {
      if (row.failure.empty()) continue;
      any = true;
      say(fmt::format("{}, {}, noise {}: {}", cell.material, cell.contestant, cell.noise,
                      row.failure));
    }
    failed += any ? 1 : 0;
  }
  return failed;
}

void PrintCost(const FrontierResult& result) {
  double session = 0;
  double reconstruction = 0;
  double scoring = 0;
  for (const FrontierCell& cell : result.cells) {
    session += cell.session_s;
    reconstruction += cell.reconstruction_s;
    scoring += cell.scoring_s;
  }
  fmt::print("CPU time         sessions {:.0f} s, reconstructions {:.0f} s, scoring {:.0f} s\n",
             session, reconstruction, scoring);
}

}  // namespace

int FrontierStudy(const StudyOptions& options, const std::filesystem::path& study_file) {
  const FrontierConfig study = LoadFrontier(study_file);
  const int threads = ThreadsOr(options.threads);
  const std::vector<FrontierMaterial> materials =
      FindFrontierMaterials(study, study_file, options.materials, threads);
  std::filesystem::create_directories(options.out);
  KeepStudyFile(study_file, options.out);

  const Interrupt interrupt;
  ProgressLine line(study.name, options.quiet);
  StudyProgress progress;
  const FrontierResult result =
      RunFrontier(study, materials, options.out, threads, line,
                  {.after_task = interrupt.after_pose(), .now = interrupt.now()}, &progress);
  fmt::print("study            {} materials, {} tasks, {} of them done before\n", materials.size(),
             progress.tasks, progress.reused);
  const std::vector<ContestantSummary> summaries = Summarise(result);
  WriteResults(options.out, result, summaries);
  const std::vector<TextTable> tables = MakeTables(result, summaries);
  for (const TextTable& table : tables) fmt::print("{}\n", ToPlainText(table));
  WriteFileAtomically(options.out / "frontier.md",
                      [&](std::ostream& out) { out << ToMarkdown(result, tables); });
  PrintCost(result);
  const int failed = ListFailures(result);
  if (failed > 0) fmt::print("failed           {} of {} tasks\n", failed, progress.tasks);
  if (!progress.whole) {
    fmt::print("stopped; the same command goes on from here\n");
    return kStoppedByUser;
  }
  WriteFrontierFigures(options.out / "figures", result, summaries);
  fmt::print("wrote            {} (frontier.md, results.csv, results.json, figures)\n",
             options.out.string());
  return failed > 0 ? kFailed : kDone;
}

}  // namespace gonio
