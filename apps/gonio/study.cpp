// SPDX-License-Identifier: Apache-2.0
// gonio study: materials x methods x thinnings.

#include <fmt/format.h>

#include <set>

#include "apps/gonio/commands.h"
#include "apps/gonio/frontier.h"
#include "apps/gonio/interrupt.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/study_pictures.h"
#include "apps/gonio/study_run.h"
#include "apps/gonio/study_summary.h"
#include "core/error.h"
#include "core/task_pool.h"

namespace gonio {
namespace {

std::string Describe(const StudyCell& cell) {
  return fmt::format("{}, {}, density {:.3g} %, {}", cell.material, cell.method,
                     100.0 / cell.keep_every, kChannelNames[cell.channel]);
}

// What could not be fitted, and what is to be remarked on, the latter once for each colour.
int ListComplaints(const StudyResult& result) {
  std::set<std::string> said;
  for (const StudyCell& cell : result.cells) {
    if (cell.warning.empty() || !cell.failure.empty()) continue;
    const std::string text =
        fmt::format("{}, {}: {}", cell.material, kChannelNames[cell.channel], cell.warning);
    if (said.insert(text).second) fmt::print(stderr, "gonio: warning: {}\n", text);
  }
  int failures = 0;
  for (const StudyCell& cell : result.cells) {
    if (cell.failure.empty()) continue;
    ++failures;
    fmt::print(stderr, "gonio: {}: {}\n", Describe(cell), cell.failure);
  }
  if (failures > 0) {
    fmt::print("failed           {} of {} cells\n", failures, result.cells.size());
  }
  return failures;
}

}  // namespace

int StudyCommand(const StudyOptions& options) {
  const std::filesystem::path file = LocateConfig(options.study.string());
  if (KindOfStudy(file) == StudyKind::kFrontier) return FrontierStudy(options, file);
  const StudyConfig study = LoadStudy(file);
  const std::vector<std::filesystem::path> materials =
      FindMaterials(study.materials, file, options.materials);
  std::filesystem::create_directories(options.out);
  KeepStudyFile(file, options.out);

  const Interrupt interrupt;
  ProgressLine line(study.name, options.quiet);
  StudyProgress progress;
  const StudyResult result = RunStudy(study, materials, options.out, ThreadsOr(options.threads),
                                      line, interrupt.after_pose(), &progress);
  fmt::print("study            {} materials, {} fits, {} of them done before\n", materials.size(),
             progress.tasks, progress.reused);
  WriteStudy(options.out, result);
  for (const MethodSummary& summary : Summarise(result)) Print(summary);
  const int failures = ListComplaints(result);
  if (!progress.whole) {
    fmt::print("stopped; the same command goes on from here\n");
    return kStoppedByUser;
  }
  WriteStudyPictures(study, materials, result, options.out);
  fmt::print("wrote            {} (cells.csv, study.json, figures)\n", options.out.string());
  return failures > 0 ? kFailed : kDone;
}

}  // namespace gonio
