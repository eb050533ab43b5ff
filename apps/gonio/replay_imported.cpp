// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/replay_imported.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "acquisition/import_session.h"
#include "acquisition/session_check.h"
#include "apps/gonio/import.h"
#include "apps/gonio/json_file.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/replay_fit.h"
#include "apps/gonio/replay_other_plan.h"
#include "core/error.h"
#include "core/sha256.h"
#include "planner/plan.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string KeyOf(const SessionRecord& record, const char* key) {
  const auto found = record.info.imported.find(key);
  return found == record.info.imported.end() ? std::string() : found->second;
}

// What is wrong with the session or the file it was made of.
std::vector<std::string> DamageOf(const fs::path& session, const fs::path& file,
                                  const std::string& sha256) {
  std::vector<std::string> damage = FindDamage(session);
  if (!fs::exists(file)) {
    damage.push_back(file.string() + ": is gone");
  } else if (Sha256OfFile(file) != sha256) {
    damage.push_back(file.string() + ": is not the file that was imported");
  }
  return damage;
}

// How many samples the file still gives as they are in the session.
int SamplesAsTheyWere(const SessionRecord& record, const ImportedFile& file) {
  const std::vector<BrdfSample> was = record.Samples();
  int same = 0;
  for (std::size_t i = 0; i < std::min(was.size(), file.samples.size()); ++i) {
    const BrdfSample& now = file.samples[i].sample;
    if ((now.f_r == was[i].f_r).all() && now.directions.wi == was[i].directions.wi &&
        now.directions.wo == was[i].directions.wo) {
      ++same;
    }
  }
  return same;
}

json OtherPlan(const ReplayOptions& options, const SessionRecord& record) {
  if (options.rig.empty()) {
    throw ConfigError(
        "--plan: nobody knows the rig of an imported session; --rig names one to measure it on");
  }
  SessionSetup setup;
  setup.rig = LoadRig(LocateConfig(options.rig));
  return ReplayOtherPlan(options.plan, setup, record.poses, record.info.seed, options.session,
                         options.out);
}

}  // namespace

int ReplayImported(const ReplayOptions& options, const SessionRecord& record) {
  if (options.rereduce || !options.calibration.empty()) {
    throw ConfigError(options.session.string() + ": was imported: it has no raw frames");
  }
  const fs::path file =
      options.session / kImportedFolder / fs::path(KeyOf(record, "file")).filename();
  const std::vector<std::string> damage = DamageOf(options.session, file, KeyOf(record, "sha256"));
  for (const std::string& one : damage) fmt::print("damage           {}\n", one);
  json numbers = {{"damage", damage}, {"turns", 0}, {"first_difference", nullptr}};
  fmt::print("decisions        none of ours: imported from {}\n", KeyOf(record, "file"));
  bool same = damage.empty();
  if (same) {
    const ImportedFile again = ReadForImport({.file = file,
                                              .out = {},
                                              .format = KeyOf(record, "format"),
                                              .bands_nm = KeyOf(record, "bands_nm"),
                                              .prior = {},
                                              .min_separation_deg = {}});
    const int as_they_were = SamplesAsTheyWere(record, again);
    fmt::print("read again       {} samples, {} as they were to the last bit\n",
               again.samples.size(), as_they_were);
    numbers["reread"] = {{"samples", again.samples.size()}, {"same", as_they_were}};
    same = as_they_were == static_cast<int>(record.Samples().size()) &&
           as_they_were == static_cast<int>(again.samples.size());
  }
  if (options.refit) {
    const Plan plan = ParsePlan(record.info.plan_text, record.info.plan_path);
    numbers["refit"] =
        Refit(record.poses, PriorOfSession(record.info), plan.fit, options.session, options.out);
  }
  if (!options.plan.empty()) numbers["other_plan"] = OtherPlan(options, record);
  if (!options.out.empty()) fmt::print("wrote            {}\n", options.out.string());
  if (!options.json.empty()) WriteJson(options.json, numbers);
  return same ? kDone : kFailed;
}

}  // namespace gonio
