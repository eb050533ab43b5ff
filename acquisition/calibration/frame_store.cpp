// SPDX-License-Identifier: Apache-2.0
#include "acquisition/calibration/frame_store.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

#include "core/config.h"
#include "core/error.h"
#include "core/file.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSettingsFile = "settings.yaml";

}  // namespace

FrameStore::FrameStore(fs::path dir, SensorFormat format, const Settings& settings, bool again)
    : dir_(std::move(dir)), format_(std::move(format)), settings_(settings) {
  if (again) fs::remove_all(dir_);
  fs::create_directories(dir_);
  if (!fs::exists(dir_ / kSettingsFile)) return;
  const ConfigNode root = ConfigNode::Load(dir_ / kSettingsFile);
  for (const auto& [key, value] : settings_) {
    const std::string was = root.TextOr(key, "not said");
    if (was == value) continue;
    throw ConfigError(
        fmt::format("{}: holds frames of other settings: {} is {}, was {}; --again starts over",
                    dir_.string(), key, value, was));
  }
  exposures_ = root.Numbers("exposures_s", 0, Range::Positive());
  root.RefuseUnknownKeys();
}

void FrameStore::FixExposures(std::vector<double> exposures) {
  exposures_ = std::move(exposures);
  WriteSettings();
}

std::optional<StoredFrame> FrameStore::Read(std::size_t index) const {
  return ReadFrameFile(FileOf(index), format_);
}

void FrameStore::Write(std::size_t index, const StoredFrame& frame) {
  WriteFrameFile(FileOf(index), format_, frame);
}

fs::path FrameStore::FileOf(std::size_t index) const {
  return dir_ / fmt::format("frame-{:04}.yaml", index + 1);
}

void FrameStore::WriteSettings() const {
  std::string text;
  for (const auto& [key, value] : settings_) {
    text += fmt::format("{}: {}\n", key, YamlQuoted(value));
  }
  text += fmt::format("exposures_s: [{}]\n", fmt::join(exposures_, ", "));
  WriteFileAtomically(dir_ / kSettingsFile, [&](std::ostream& out) { out << text; });
}

}  // namespace gonio
