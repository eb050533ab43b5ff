// SPDX-License-Identifier: Apache-2.0
// gonio export: sessions, fits and other reflectances in other people's formats.

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>

#include "acquisition/session_record.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/tabulate.h"
#include "brdf/merl_table.h"
#include "brdf/samples_csv.h"
#include "core/error.h"
#include "core/units.h"

namespace gonio {
namespace {

// A fit may lack a colour, which a table has no way to say.
void RequireEveryColour(const Brdf& brdf, const std::filesystem::path& input) {
  const std::optional<Rgb> f_r =
      brdf.Eval(HalfDiff{.theta_h = 0.2, .theta_d = 0.2, .phi_d = kPi / 2});
  for (int c = 0; f_r && c < kChannels; ++c) {
    if (std::isnan((*f_r)[c])) {
      throw ConfigError(
          fmt::format("{}: has no {}, which could not be fitted; a table needs all "
                      "three colours",
                      input.string(), kChannelNames[c]));
    }
  }
}

void ExportMerl(const std::filesystem::path& input, const std::filesystem::path& out) {
  const std::unique_ptr<Brdf> brdf = OpenAny(LocateConfig(input.string()));
  RequireEveryColour(*brdf, input);
  Tabulate(*brdf).Write(out);
}

void ExportCsv(const std::filesystem::path& input, const std::filesystem::path& out) {
  const SessionRecord session = ReadSession(input);
  std::vector<MeasuredSample> rows;
  for (const MeasuredPose& pose : session.poses) {
    for (const BrdfSample& sample : pose.samples) {
      rows.push_back({pose.pose, sample, pose.end.count()});
    }
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
