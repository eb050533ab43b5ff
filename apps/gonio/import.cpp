// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <utility>

#include "apps/gonio/commands.h"
#include "apps/gonio/open_any.h"
#include "brdf/cornell_brdf.h"
#include "brdf/rt300s_csv.h"
#include "core/error.h"
#include "core/file.h"
#include "core/units.h"
#include "planner/plan.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

// Between the arms, from readings of NiTE_on_invar and MagicBlack: up to 3 deg the receiver stands
// in the light, at 4 and 5 deg its edge glints.
constexpr double kRt300sSeparationDeg = 5.5;

// What every command that fits a session asks its plan.
constexpr const char* kPlanText =
    "# No plan chose these poses: they were measured elsewhere. This says how they are fitted.\n"
    "version: 1\nname: imported\nplanner: grid\n";

std::string FormatOf(const ImportOptions& options, const std::string& bytes) {
  if (options.format != "auto") return options.format;
  std::string extension = options.file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  if (extension == ".brdf") return "cornell";
  if (extension == ".csv") return LooksLikeRt300s(bytes) ? "rt300s" : "csv";
  throw ConfigError(
      fmt::format("{}: has the extension \"{}\", must be .csv or .brdf; or name a --format",
                  options.file.string(), extension));
}

// "600-700,500-590,440-490"
WavelengthBands BandsOf(const std::string& text) {
  if (text.empty()) return kColourBands;
  WavelengthBands bands{};
  int read = 0;
  const int numbers =
      std::sscanf(text.c_str(), "%lf-%lf,%lf-%lf,%lf-%lf%n", &bands[0].from_nm, &bands[0].to_nm,
                  &bands[1].from_nm, &bands[1].to_nm, &bands[2].from_nm, &bands[2].to_nm, &read);
  const bool ordered = std::all_of(bands.begin(), bands.end(), [](const WavelengthBand& band) {
    return band.from_nm > 0 && band.from_nm <= band.to_nm;
  });
  if (numbers != 6 || read != static_cast<int>(text.size()) || !ordered) {
    throw ConfigError("--bands-nm: must be like 600-700,500-590,440-490 (red, green, blue), is \"" +
                      text + "\"");
  }
  return bands;
}

void ReadCsv(const std::string& name, ImportedFile* file) {
  file->samples = ParseSamplesCsv(file->bytes, name);
  file->quantity = "f_r, 1/sr";
  file->channels = "as in the file";
}

void ReadRt300s(const std::string& name, ImportedFile* file) {
  Rt300sSession session = ParseRt300s(file->bytes, name);
  file->samples = std::move(session.samples);
  file->started = std::move(session.started);
  file->quantity = "f_r = RT / cos(receive_deg), 1/sr";
  file->channels = "RT, the only one, for all three";
}

void ReadCornell(const std::string& name, const std::string& bands_text, ImportedFile* file) {
  const WavelengthBands bands = BandsOf(bands_text);
  CornellBrdf brdf = ParseCornell(file->bytes, name, bands);
  file->samples = std::move(brdf.samples);
  file->title = std::move(brdf.title);
  file->quantity = "f_r, 1/sr";
  file->channels = "means over";
  for (int c = 0; c < kChannels; ++c) {
    file->channels += fmt::format("{} {} to {} nm ({})", c > 0 ? "," : "", bands[c].from_nm,
                                  bands[c].to_nm, kChannelNames[c]);
  }
  if (brdf.zeros > 0) {
    fmt::print("zeros            {} of {} channels are exactly zero: cut off there\n", brdf.zeros,
               kChannels * file->samples.size());
  }
}

SessionInfo Describe(const ImportOptions& options, const ImportedFile& file) {
  Plan plan = ParsePlan(kPlanText, "the plan of imported sessions");
  plan.Believe(OpenPrior(options.prior, plan.prior.shape));
  SessionInfo info;
  info.gonio_version = GONIO_VERSION;
  info.rig_name = file.format == "csv" ? "unknown" : file.format;
  info.plan_text = kPlanText;
  info.prior_name = plan.prior.name;
  info.prior_spec =
      IsBuiltInPrior(options.prior) ? options.prior : fs::absolute(options.prior).string();
  info.prior_sha256 = HashOf(plan.prior);
  return info;
}

void Print(const ImportedFile& file, int shadowed) {
  const auto negative =
      std::count_if(file.samples.begin(), file.samples.end(),
                    [](const MeasuredSample& m) { return (m.sample.f_r < 0).any(); });
  fmt::print("imported         {} samples as {} ({}; channels: {})\n", file.samples.size(),
             file.format, file.quantity, file.channels);
  fmt::print("negative         {} samples, kept\n", negative);
  if (shadowed > 0) {
    fmt::print(
        "shadowed         {} samples with the arms too near to each other, kept but not "
        "fitted\n",
        shadowed);
  }
}

}  // namespace

ImportedFile ReadForImport(const ImportOptions& options) {
  ImportedFile file;
  file.path = options.file;
  file.bytes = ReadTextFile(options.file);
  file.format = FormatOf(options, file.bytes);
  if (file.format != "cornell" && !options.bands_nm.empty()) {
    throw ConfigError("--bands-nm: only a cornell file has wavelengths to choose from");
  }
  const std::string name = options.file.string();
  if (file.format == "rt300s") {
    ReadRt300s(name, &file);
  } else if (file.format == "cornell") {
    ReadCornell(name, options.bands_nm, &file);
    file.bands_nm = options.bands_nm;
  } else {
    ReadCsv(name, &file);
  }
  return file;
}

int ImportCommand(const ImportOptions& options) {
  if (fs::exists(fs::symlink_status(options.out))) {
    throw ConfigError(options.out.string() +
                      ": exists already; a session never reuses a directory, name another");
  }
  ImportedFile file = ReadForImport(options);
  const double separation_deg =
      options.min_separation_deg.value_or(file.format == "rt300s" ? kRt300sSeparationDeg : 0);
  const int shadowed = MarkShadowed(RadFromDeg(separation_deg), &file.samples);
  WriteImportedSession(options.out, Describe(options, file), file);
  Print(file, shadowed);
  fmt::print("wrote            {}\n", options.out.string());
  return kDone;
}

}  // namespace gonio
