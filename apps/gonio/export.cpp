// SPDX-License-Identifier: Apache-2.0
// gonio export: sessions, fits and other reflectances in other people's formats.

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>

#include "acquisition/radiometry/frame_file.h"
#include "acquisition/session_frames.h"
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

// Where the samples are from, in one line.
std::string OriginOf(const SessionInfo& info) {
  if (info.imported.empty()) return fmt::format("rig {}, seed {}", info.rig_name, info.seed);
  std::string text;
  for (const auto& [key, value] : info.imported) {
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", key, value);
  }
  return text;
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
  WriteSamplesCsv(
      out, rows,
      {fmt::format("gonio {} session of {}", info.gonio_version, info.created_utc), OriginOf(info),
       session.end ? fmt::format("{}: {}", session.end->outcome, session.end->reason)
                   : std::string("session did not end properly")});
}

// What a frame's file leaves to its reader, of whatever camera.
SensorFormat FormatOf(const Frame& frame) {
  SensorFormat format;
  format.width = frame.width;
  format.height = frame.height;
  format.layout = frame.layout;
  format.gain_db = frame.gain_db;
  return format;
}

// Returns how many there are. DIR/pose-0001/frame-01.tiff, ....
int ExportFrames(const std::filesystem::path& input, const std::filesystem::path& out) {
  namespace fs = std::filesystem;
  if (fs::exists(fs::symlink_status(out))) {
    throw ConfigError(out.string() + ": exists already; name a folder that does not");
  }
  const std::vector<MeasuredPose> poses = ReadSession(input).poses;
  const int last = poses.empty() ? 0 : poses.back().pose;
  SessionFrames frames(input);
  int written = 0;
  // Poses without a sample have frames, too: after the last one a session may have been killed.
  for (int pose = 1;; ++pose) {
    const std::vector<Exposure> exposures = frames.Of(pose);
    if (exposures.empty() && pose > last) break;
    const fs::path folder = out / fmt::format("pose-{:04}", pose);
    if (!exposures.empty()) fs::create_directories(folder);
    int number = 0;
    for (const Exposure& exposure : exposures) {
      WriteFrameFile(folder / fmt::format("frame-{:02}.yaml", ++number), FormatOf(exposure.frame),
                     {exposure.frame, exposure.monitor, exposure.colour});
    }
    written += number;
  }
  if (written == 0) throw ConfigError(input.string() + ": holds no raw frame");
  return written;
}

}  // namespace

int ExportCommand(const ExportOptions& options) {
  if (options.format.empty() && options.frames.empty()) {
    throw ConfigError("export: needs --to or --frames");
  }
  if (options.format.empty() != options.out.empty()) {
    throw ConfigError("export: --to and a file to write belong together");
  }
  if (!options.frames.empty()) {
    const int frames = ExportFrames(options.input, options.frames);
    fmt::print("wrote            {}: {} frames\n", options.frames.string(), frames);
  }
  if (options.format.empty()) return kDone;
  if (options.format == "merl") {
    ExportMerl(options.input, options.out);
  } else {
    ExportCsv(options.input, options.out);
  }
  fmt::print("wrote            {}\n", options.out.string());
  return kDone;
}

}  // namespace gonio
