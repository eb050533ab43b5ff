// SPDX-License-Identifier: Apache-2.0
// gonio export: a session or a fit in other people's formats.

#include <fmt/format.h>

#include "acquisition/session_record.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/open_any.h"
#include "brdf/merl_table.h"
#include "brdf/samples_csv.h"
#include "core/error.h"

namespace gonio {
namespace {

void ExportMerl(const std::filesystem::path& input, const std::filesystem::path& out) {
  if (!std::filesystem::is_directory(input) && !IsFitFile(input)) {
    throw ConfigError(input.string() + ": is neither a session directory nor a fit file");
  }
  const std::unique_ptr<Brdf> brdf = OpenAny(input);
  const MerlTable table = MerlTable::FromFunction(
      out.stem().string(), [&](const HalfDiff& angles) { return brdf->Eval(angles); });
  table.Write(out);
}

void ExportCsv(const std::filesystem::path& input, const std::filesystem::path& out) {
  const SessionRecord session = ReadSession(input);
  std::vector<MeasuredSample> rows;
  for (const MeasuredPose& pose : session.poses) {
    rows.push_back({pose.pose, pose.sample, pose.end.count()});
  }
  if (rows.empty()) throw ConfigError(input.string() + ": holds no sample to export");
  const SessionInfo& info = session.info;
  WriteSamplesCsv(out, rows,
                  {fmt::format("gonio {} session of {}", info.gonio_version, info.created_utc),
                   fmt::format("rig {}, seed {}", info.rig_name, info.seed),
                   session.end ? fmt::format("{}: {}", session.end->outcome, session.end->reason)
                               : std::string("session did not end properly")});
}

}  // namespace

int ExportCommand(const ExportOptions& options) {
  if (options.format == "merl") {
    ExportMerl(options.input, options.out);
  } else {
    ExportCsv(options.input, options.out);
  }
  fmt::print("wrote            {}\n", options.out.string());
  return kDone;
}

}  // namespace gonio
