// SPDX-License-Identifier: Apache-2.0
#include "acquisition/import_session.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <stdexcept>
#include <utility>

#include "core/file.h"
#include "core/sha256.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

using Samples = std::span<const MeasuredSample>;

std::map<std::string, std::string> Source(const ImportedFile& file, const SessionInfo& info) {
  std::map<std::string, std::string> source = {
      {"file", file.path.filename().string()},
      {"sha256", Sha256(file.bytes)},
      {"format", file.format},
      {"importer", "gonio " + info.gonio_version},
      {"quantity", file.quantity},
      {"channels", file.channels},
      {"raw_frames", "none"},
  };
  if (!file.bands_nm.empty()) source["bands_nm"] = file.bands_nm;
  if (!file.title.empty()) source["title"] = file.title;
  if (!file.started.empty()) source["started"] = file.started;
  return source;
}

// As if each arm had an azimuth and an elevation (docs/geometry.md).
ArmAngles ArmsAt(const DirectionPair& pair) {
  const auto azimuth = [](const Eigen::Vector3d& w) { return std::atan2(w.y(), w.x()); };
  const auto elevation = [](const Eigen::Vector3d& w) {
    return std::atan2(w.z(), std::hypot(w.x(), w.y()));
  };
  return {azimuth(pair.wi), elevation(pair.wi), azimuth(pair.wo), elevation(pair.wo)};
}

// `parts`: of one pose, not empty.
Result<void> AppendPose(EventLog& log, int number, Samples parts) {
  const DirectionPair& pair = parts.front().sample.directions;
  const Proposal proposal{.directions = pair,
                          .candidate = -1,
                          .score = std::numeric_limits<double>::quiet_NaN(),
                          .reason = "imported",
                          .frames = 0};
  const Seconds time(parts.back().time_s);
  PoseRecord record;
  record.commanded = record.readback = ArmsAt(pair);
  record.start = Seconds(parts.front().time_s);
  record.end = time;
  const Result<void> raw = log.AppendPose(
      {.pose = number, .proposal = proposal, .predicted_error = {}, .after = {}}, record);
  if (!raw.ok()) return raw;
  std::vector<ReducedSample> reduced;
  for (const MeasuredSample& part : parts) {
    reduced.push_back({.sample = part.sample, .budget = {}});
  }
  return log.AppendSamples(number, time, reduced);
}

Result<void> AppendAll(EventLog& log, Samples samples, const std::string& name) {
  int poses = 0;
  double duration_s = 0;
  while (!samples.empty()) {
    const auto next = std::find_if(samples.begin(), samples.end(), [&](const MeasuredSample& m) {
      return m.pose != samples.front().pose;
    });
    const auto parts = static_cast<std::size_t>(next - samples.begin());
    const Result<void> appended = AppendPose(log, ++poses, samples.first(parts));
    if (!appended.ok()) return appended;
    duration_s = std::max(duration_s, samples[parts - 1].time_s);
    samples = samples.subspan(parts);
  }
  return log.AppendEnd(Seconds(duration_s), {.outcome = "complete",
                                             .reason = "imported from " + name,
                                             .poses = poses,
                                             .duration = Seconds(duration_s),
                                             .predicted_error = {}});
}

}  // namespace

void WriteImportedSession(const fs::path& dir, SessionInfo info, const ImportedFile& file) {
  info.imported = Source(file, info);
  EventLog log = EventLog::Create(dir, std::move(info));
  try {
    fs::create_directory(dir / kImportedFolder);
    WriteFileAtomically(dir / kImportedFolder / file.path.filename(),
                        [&](std::ostream& out) { out << file.bytes; });
    const Result<void> appended = log.AppendTogether(
        [&] { return AppendAll(log, file.samples, file.path.filename().string()); });
    if (!appended.ok()) throw std::runtime_error(appended.error().message);
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(dir, ignored);
    throw;
  }
}

int MarkShadowed(double min_separation, std::vector<MeasuredSample>* samples) {
  int marked = 0;
  for (MeasuredSample& m : *samples) {
    if (AngleBetween(m.sample.directions.wi, m.sample.directions.wo) >= min_separation) continue;
    m.sample.sigma.setConstant(std::numeric_limits<double>::infinity());
    ++marked;
  }
  return marked;
}

}  // namespace gonio
