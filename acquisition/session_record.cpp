// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session_record.h"

#include <fmt/format.h>

#include <charconv>
#include <limits>
#include <nlohmann/json.hpp>

#include "acquisition/event_log_sqlite.h"
#include "acquisition/session_format.h"
#include "core/units.h"

namespace gonio {
namespace {

using nlohmann::json;

template <typename Number>
Number NumberOf(const std::string& text) {
  Number number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

std::map<std::string, std::string> TextsOf(const std::string& text) {
  std::map<std::string, std::string> texts;
  const json object = json::parse(text);  // items() below refers to it
  for (const auto& [key, value] : object.items()) texts[key] = value.get<std::string>();
  return texts;
}

using Meta = std::map<std::string, std::string>;

void Take(const Meta& meta, const char* key, std::string* text) {
  if (const auto found = meta.find(key); found != meta.end()) *text = found->second;
}

template <typename Number>
void Take(const Meta& meta, const char* key, Number* number) {
  if (const auto found = meta.find(key); found != meta.end()) {
    *number = NumberOf<Number>(found->second);
  }
}

void Take(const Meta& meta, const char* key, std::map<std::string, std::string>* texts) {
  if (const auto found = meta.find(key); found != meta.end()) *texts = TextsOf(found->second);
}

// What `meta` has takes the place of what was there; older formats have less.
void TakeAll(const Meta& meta, SessionInfo* info) {
  Take(meta, "gonio_version", &info->gonio_version);
  Take(meta, "created_utc", &info->created_utc);
  Take(meta, "seed", &info->seed);
  Take(meta, "max_poses", &info->max_poses);
  Take(meta, "rig_name", &info->rig_name);
  Take(meta, "rig_path", &info->rig_path);
  Take(meta, "rig_text", &info->rig_text);
  Take(meta, "plan_path", &info->plan_path);
  Take(meta, "plan_text", &info->plan_text);
  Take(meta, "prior_name", &info->prior_name);
  Take(meta, "prior_spec", &info->prior_spec);
  Take(meta, "prior_sha256", &info->prior_sha256);
  Take(meta, "material_path", &info->material_path);
  Take(meta, "material_sha256", &info->material_sha256);
  Take(meta, "devices", &info->devices);
  Take(meta, "calibrations", &info->calibrations);
  Take(meta, "imported", &info->imported);
}

SessionInfo ReadInfo(sqlite::Database& db) {
  Meta meta;
  sqlite::Statement rows(db, "SELECT key, value FROM meta");
  while (rows.Step()) meta[rows.Text(0)] = rows.Text(1);
  SessionInfo info;
  TakeAll(meta, &info);
  return info;
}

std::optional<double> RealOrNull(const sqlite::Statement& row, int column) {
  return row.IsNull(column) ? std::nullopt : std::optional<double>(row.Real(column));
}

BrdfSample ReadSample(const sqlite::Statement& row, int first) {
  BrdfSample sample;
  for (int i = 0; i < 3; ++i) {
    sample.directions.wi[i] = row.Real(first + i);
    sample.directions.wo[i] = row.Real(first + 3 + i);
    sample.f_r[i] = row.Real(first + 6 + i);
    sample.sigma[i] =
        RealOrNull(row, first + 9 + i).value_or(std::numeric_limits<double>::infinity());
  }
  return sample;
}

Rgb ReadSystematic(const sqlite::Statement& row, int first) {
  Rgb systematic;
  for (int i = 0; i < 3; ++i) {
    systematic[i] = RealOrNull(row, first + i).value_or(std::numeric_limits<double>::infinity());
  }
  return systematic;
}

// The columns of the axes, as if every rig had all that there may be.
std::string Positions(const std::vector<std::string>& axes) {
  std::string columns;
  const std::vector<std::string> names = PositionColumns(axes);
  for (std::size_t i = 0; i < 2 * kAxes; ++i) {
    const std::size_t axis = i % kAxes;
    columns += i == 0 ? "" : ", ";
    columns += axis < axes.size() ? "p." + names[i / kAxes * axes.size() + axis] : "0.0";
  }
  return columns;
}

std::vector<MeasuredPose> ReadPoses(sqlite::Database& db, std::int64_t version,
                                    const std::vector<std::string>& axes) {
  constexpr int kFirstSampleColumn = 22;
  constexpr int kFirstSystematicColumn = 34;
  const char* const systematic =
      version >= 3 ? "s.sigma_systematic_red, s.sigma_systematic_green, s.sigma_systematic_blue"
                   : "0.0, 0.0, 0.0";
  const std::string select =
      "SELECT p.pose, p.candidate, p.reason, p.score, p.theta_h_deg, p.theta_d_deg, p.phi_d_deg,"
      " p.move_retries, p.start_s, p.move_s, p.end_s, p.predicted_error,"
      " (SELECT count(*) FROM exposures e WHERE e.pose = p.pose),"
      " " +
      Positions(axes) +
      ", (SELECT total(exposure_s) FROM exposures e WHERE e.pose = p.pose),"
      " s.wi_x, s.wi_y, s.wi_z, s.wo_x, s.wo_y, s.wo_z, s.f_r_red, s.f_r_green, s.f_r_blue,"
      " s.sigma_red, s.sigma_green, s.sigma_blue, " +
      std::string(systematic) +
      " FROM poses p LEFT JOIN samples s USING (pose) ORDER BY p.pose, s.part";
  sqlite::Statement row(db, select.c_str());
  std::vector<MeasuredPose> poses;
  while (row.Step()) {
    if (!poses.empty() && poses.back().pose == row.Integer(0)) {
      poses.back().samples.push_back(ReadSample(row, kFirstSampleColumn));
      poses.back().systematic.push_back(ReadSystematic(row, kFirstSystematicColumn));
      continue;
    }
    MeasuredPose& pose = poses.emplace_back();
    pose.pose = static_cast<int>(row.Integer(0));
    pose.candidate = static_cast<int>(row.Integer(1));
    pose.reason = row.Text(2);
    pose.score = RealOrNull(row, 3);
    pose.planned = {RadFromDeg(row.Real(4)), RadFromDeg(row.Real(5)), RadFromDeg(row.Real(6))};
    pose.move_retries = static_cast<int>(row.Integer(7));
    pose.start = Seconds(row.Real(8));
    pose.move_time = Seconds(row.Real(9));
    pose.end = Seconds(row.Real(10));
    pose.predicted_error = RealOrNull(row, 11);
    pose.frames = static_cast<int>(row.Integer(12));
    for (int i = 0; i < kAxes; ++i) {
      pose.commanded[i] = RadFromDeg(row.Real(13 + i));
      pose.readback[i] = RadFromDeg(row.Real(17 + i));
    }
    pose.exposed = Seconds(row.Real(21));
    if (row.IsNull(kFirstSampleColumn)) continue;  // killed before it was reduced
    pose.samples.push_back(ReadSample(row, kFirstSampleColumn));
    pose.systematic.push_back(ReadSystematic(row, kFirstSystematicColumn));
  }
  return poses;
}

// Formats before the fourth know no colours of the light.
std::map<std::string, int> CountByColour(sqlite::Database& db, std::int64_t version) {
  std::map<std::string, int> frames;
  if (version < 4) return frames;
  sqlite::Statement row(
      db, "SELECT colour, count(*) FROM exposures WHERE colour IS NOT NULL GROUP BY colour");
  while (row.Step()) frames[row.Text(0)] = static_cast<int>(row.Integer(1));
  return frames;
}

std::vector<SessionEvent> ReadEvents(sqlite::Database& db) {
  sqlite::Statement row(db, "SELECT seq, time_s, kind, body FROM events ORDER BY seq");
  std::vector<SessionEvent> events;
  while (row.Step()) {
    events.push_back(
        {static_cast<int>(row.Integer(0)), Seconds(row.Real(1)), row.Text(2), row.Text(3)});
  }
  return events;
}

// Poses are numbered without gaps, and all but the last have samples.
void CheckWhole(const std::filesystem::path& dir, const std::vector<MeasuredPose>& poses) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const int expected = static_cast<int>(i) + 1;
    const bool missing = poses[i].pose != expected;
    if (!missing && (!poses[i].samples.empty() || i + 1 == poses.size())) continue;
    throw ConfigError(fmt::format("{}: is damaged: pose {} {}", (dir / kSessionFile).string(),
                                  expected, missing ? "is missing" : "has no samples"));
  }
}

// What the tables have rounded, to the last bit.
void TakeExactAngles(const std::vector<SessionEvent>& events, std::vector<MeasuredPose>* poses) {
  for (const SessionEvent& event : events) {
    if (event.kind != "pose_measured") continue;
    const json body = json::parse(event.body);
    const std::size_t i = body.at("pose").get<std::size_t>() - 1;
    if (i >= poses->size() || !body.contains("commanded_rad")) continue;
    MeasuredPose& pose = (*poses)[i];
    pose.commanded = body["commanded_rad"].get<AxisPositions>();
    pose.readback = body["readback_rad"].get<AxisPositions>();
    pose.frames_wanted = body.value("frames_wanted", 1);
  }
}

std::optional<SessionEnd> FindEnd(const std::vector<SessionEvent>& events) {
  if (events.empty() || events.back().kind != "session_end") return std::nullopt;
  const json body = json::parse(events.back().body);
  SessionEnd end;
  end.outcome = body.at("outcome").get<std::string>();
  end.reason = body.at("reason").get<std::string>();
  end.poses = body.at("poses").get<int>();
  end.rejected = body.at("rejected").get<int>();
  end.duration = Seconds(body.at("duration_s").get<double>());
  if (body.contains("predicted_error")) end.predicted_error = body["predicted_error"].get<double>();
  return end;
}

}  // namespace

std::vector<BrdfSample> SessionRecord::Samples() const {
  std::vector<BrdfSample> samples;
  for (const MeasuredPose& pose : poses) {
    samples.insert(samples.end(), pose.samples.begin(), pose.samples.end());
  }
  return samples;
}

SessionInfo InfoAfter(const SessionInfo& info, const std::string& body) {
  SessionInfo after = info;
  TakeAll(json::parse(body).at("now").get<Meta>(), &after);
  return after;
}

SessionInfo LatestInfo(const SessionRecord& record) {
  SessionInfo info = record.info;
  for (const SessionEvent& event : record.events) {
    if (event.kind == "session_resumed") info = InfoAfter(info, event.body);
  }
  return info;
}

bool IsSession(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path / kSessionFile, ignored);
}

void CheckSession(const std::filesystem::path& dir) {
  if (!std::filesystem::is_directory(dir)) {
    throw ConfigError(dir.string() + ": is not a session: no such directory");
  }
  if (!IsSession(dir)) {
    throw ConfigError(fmt::format("{}: is not a session: has no {}", dir.string(), kSessionFile));
  }
}

SessionRecord ReadSession(const std::filesystem::path& dir) {
  CheckSession(dir);
  try {
    sqlite::Database db(dir / kSessionFile, SQLITE_OPEN_READONLY);
    sqlite::Transaction transaction(db, "BEGIN");  // one moment of a session that may be running
    const std::int64_t version = CheckSessionFormat(db);
    SessionRecord record;
    record.info = ReadInfo(db);
    record.info.axes = AxesIn(db);
    record.poses = ReadPoses(db, version, record.info.axes);
    record.frames_by_colour = CountByColour(db, version);
    record.events = ReadEvents(db);
    record.end = FindEnd(record.events);
    CheckWhole(dir, record.poses);
    TakeExactAngles(record.events, &record.poses);
    if (!record.poses.empty() && record.poses.back().samples.empty()) {
      record.unreduced = std::move(record.poses.back());
      record.poses.pop_back();
    }
    return record;
  } catch (const sqlite::Failure& e) {
    throw ConfigError(e.what());
  } catch (const json::exception& e) {
    throw ConfigError(fmt::format("{}: is damaged: {}", (dir / kSessionFile).string(), e.what()));
  }
}

}  // namespace gonio
