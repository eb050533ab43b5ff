// SPDX-License-Identifier: Apache-2.0
#include "acquisition/event_log.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "acquisition/event_bodies.h"
#include "acquisition/event_log_sqlite.h"
#include "acquisition/session_format.h"
#include "acquisition/session_record.h"
#include "core/check.h"
#include "core/dir_lock.h"
#include "core/sha256.h"
#include "core/units.h"
#include "core/utc.h"

namespace gonio {
namespace {

using nlohmann::json;

std::vector<std::uint8_t> LittleEndian(const std::vector<std::uint16_t>& counts) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(2 * counts.size());
  for (const std::uint16_t count : counts) {
    bytes.push_back(static_cast<std::uint8_t>(count & 0xff));
    bytes.push_back(static_cast<std::uint8_t>(count >> 8));
  }
  return bytes;
}

std::string_view AsText(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// NULL for infinity, which is no SQL number: the sigma of a channel that could not be measured.
std::optional<double> FiniteOrNull(double number) {
  return std::isfinite(number) ? std::optional<double>(number) : std::nullopt;
}

std::optional<std::string> NameOrNull(const std::optional<LightColour>& colour) {
  return colour ? std::optional<std::string>(ToString(*colour)) : std::nullopt;
}

// Makes the entry of a new directory durable. Best effort: some file systems refuse.
void SyncDirectory(const std::filesystem::path& dir) {
  const int fd = ::open(dir.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

double Azimuth(const Eigen::Vector3d& v) { return DegFromRad(std::atan2(v.y(), v.x())); }

double Polar(const Eigen::Vector3d& v) {
  return DegFromRad(AngleBetween(v, Eigen::Vector3d::UnitZ()));
}

void WriteMeta(sqlite::Database& db, const SessionInfo& info) {
  sqlite::Statement insert(db, "INSERT INTO meta (key, value) VALUES (?, ?)");
  const auto put = [&](const std::string& key, const std::string& text) { insert.Run(key, text); };
  put("format", std::to_string(kSessionFormat));
  put("gonio_version", info.gonio_version);
  put("created_utc", info.created_utc);
  put("seed", std::to_string(info.seed));
  put("max_poses", std::to_string(info.max_poses));
  put("rig_name", info.rig_name);
  put("rig_path", info.rig_path);
  put("rig_text", info.rig_text);
  put("rig_sha256", Sha256(info.rig_text));
  put("plan_path", info.plan_path);
  put("plan_text", info.plan_text);
  put("plan_sha256", Sha256(info.plan_text));
  put("prior_name", info.prior_name);
  put("prior_spec", info.prior_spec);
  put("prior_sha256", info.prior_sha256);
  put("material_path", info.material_path);
  put("material_sha256", info.material_sha256);
  put("devices", json(info.devices).dump());
  put("calibrations", json(info.calibrations).dump());
  if (!info.imported.empty()) put("imported", json(info.imported).dump());
}

}  // namespace

struct EventLog::Impl {
  Impl(const std::filesystem::path& dir, int flags)
      : lock(dir), db(dir / kSessionFile, SQLITE_OPEN_READWRITE | flags) {
    db.Execute("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON");
  }

  // All of `body` in one transaction; what SQLite refuses becomes a kStorage error.
  template <typename Body>
  Result<void> Write(const Body& body) {
    try {
      std::optional<sqlite::Transaction> transaction;
      if (!together) transaction.emplace(db);
      body();
      if (transaction) transaction->Commit();
    } catch (const sqlite::Failure& e) {
      return Error{ErrorCode::kStorage, e.what()};
    }
    return {};
  }

  void InsertEvent(Seconds time, const std::string& kind, const json& body) {
    sqlite::Statement(db, "INSERT INTO events (time_s, kind, body) VALUES (?, ?, ?)")
        .Run(time.count(), kind, body.dump(-1, ' ', false, json::error_handler_t::replace));
  }

  void InsertPose(const PoseNote& note, const PoseRecord& record) {
    const HalfDiff planned = ToHalfDiff(note.proposal.directions);
    const std::size_t count = AxesIn(db).size();
    std::vector<double> positions;
    for (const AxisPositions& axes : {record.commanded, record.readback}) {
      for (std::size_t i = 0; i < count; ++i) positions.push_back(DegFromRad(axes[i]));
    }
    std::string places = "?, ?, ?, ?, ?, ?, ?";
    for (std::size_t i = 0; i < positions.size() + 5; ++i) places += ", ?";
    sqlite::Statement(db, ("INSERT INTO poses VALUES (" + places + ")").c_str())
        .Run(note.pose, note.proposal.candidate, note.proposal.reason,
             FiniteOrNull(note.proposal.score), DegFromRad(planned.theta_h),
             DegFromRad(planned.theta_d), DegFromRad(planned.phi_d),
             std::span<const double>(positions), record.move_retries, record.start.count(),
             record.move_time.count(), record.end.count(), note.predicted_error);
  }

  // Returns the SHA-256 of the frame as it is kept.
  std::string InsertExposure(int pose, int number, const Exposure& exposure) {
    const Frame& frame = exposure.frame;
    const std::vector<std::uint8_t> bytes = LittleEndian(frame.counts);
    sqlite::Statement(db,
                      "INSERT INTO exposures (pose, frame, exposure_s, black_level, monitor, "
                      "start_s, gain_db, temperature_c, width, height, layout, colour, "
                      "saturated_red, saturated_green, saturated_blue, counts) "
                      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
        .Run(pose, number, frame.exposure.count(), frame.black_level, exposure.monitor,
             frame.start.count(), frame.gain_db, frame.temperature_c, frame.width, frame.height,
             std::string(ToString(frame.layout)), NameOrNull(exposure.colour),
             int{exposure.saturated[0]}, int{exposure.saturated[1]}, int{exposure.saturated[2]},
             std::span<const std::uint8_t>(bytes));
    return Sha256(AsText(bytes));
  }

  void InsertSample(int pose, int part, const ReducedSample& reduced) {
    const BrdfSample& sample = reduced.sample;
    const Rgb systematic = reduced.budget.systematic();
    const auto systematic_of = [&](int c) {
      return std::isfinite(sample.sigma[c]) ? FiniteOrNull(systematic[c]) : std::nullopt;
    };
    const Eigen::Vector3d& wi = sample.directions.wi;
    const Eigen::Vector3d& wo = sample.directions.wo;
    const HalfDiff angles = ToHalfDiff(sample.directions);
    sqlite::Statement(db,
                      "INSERT INTO samples VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, "
                      "?, ?, ?, ?, ?, ?, ?, ?)")
        .Run(pose, part, Polar(wi), Azimuth(wi), Polar(wo), Azimuth(wo), DegFromRad(angles.theta_h),
             DegFromRad(angles.theta_d), DegFromRad(angles.phi_d), wi.x(), wi.y(), wi.z(), wo.x(),
             wo.y(), wo.z(), sample.f_r[0], sample.f_r[1], sample.f_r[2],
             FiniteOrNull(sample.sigma[0]), FiniteOrNull(sample.sigma[1]),
             FiniteOrNull(sample.sigma[2]), systematic_of(0), systematic_of(1), systematic_of(2));
  }

  DirLock lock;
  sqlite::Database db;
  bool together = false;  // in the transaction of AppendTogether()
};

EventLog::EventLog(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
EventLog::EventLog(EventLog&&) noexcept = default;
EventLog& EventLog::operator=(EventLog&&) noexcept = default;

EventLog::~EventLog() {
  // A finished session is one plain file, readable from a read-only disk. Not worth an error if it
  // does not work (a reader may be looking): the write-ahead log beside it then stays in force.
  if (impl_ == nullptr) return;
  sqlite3_exec(impl_->db.get(), "PRAGMA journal_mode = DELETE", nullptr, nullptr, nullptr);
}

EventLog EventLog::Create(const std::filesystem::path& dir, SessionInfo info) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path parent = fs::absolute(dir).parent_path();
  if (!fs::is_directory(parent, error)) {
    throw ConfigError(fmt::format("{}: cannot make this directory: {} does not exist", dir.string(),
                                  parent.string()));
  }
  // create_directory() is the exclusive claim: of two processes one gets `true`.
  const bool made = fs::create_directory(dir, error);
  if (!made && (!error || error == std::errc::file_exists || fs::exists(dir))) {
    throw ConfigError(fmt::format(
        "{}: exists already; a session never reuses a directory, name another", dir.string()));
  }
  if (!made) {
    throw ConfigError(
        fmt::format("{}: cannot make this directory: {}", dir.string(), error.message()));
  }
  try {
    auto impl = std::make_unique<Impl>(dir, SQLITE_OPEN_CREATE);
    if (info.created_utc.empty()) info.created_utc = UtcText(std::time(nullptr));
    sqlite::Transaction transaction(impl->db);
    CreateSessionTables(impl->db, info.axes);
    WriteMeta(impl->db, info);
    impl->InsertEvent(Seconds(0), "session_start", {{"seed", info.seed}, {"rig", info.rig_name}});
    transaction.Commit();
    SyncDirectory(parent);
    return EventLog(std::move(impl));
  } catch (...) {
    fs::remove_all(dir, error);
    throw;
  }
}

EventLog EventLog::Open(const std::filesystem::path& dir) {
  CheckSession(dir);
  try {
    auto impl = std::make_unique<Impl>(dir, 0);
    const std::int64_t version = CheckSessionFormat(impl->db);
    if (version < kOldestResumedFormat) {
      throw ConfigError(
          fmt::format("{}: has session format {}, which can be read but not gone on "
                      "with; formats {} to {} can",
                      dir.string(), version, kOldestResumedFormat, kSessionFormat));
    }
    if (version < kSessionFormat) BringSessionUpToDate(impl->db);
    return EventLog(std::move(impl));
  } catch (const sqlite::Failure& e) {
    throw ConfigError(e.what());
  }
}

Result<void> EventLog::AppendPose(const PoseNote& note, const PoseRecord& record) {
  return impl_->Write([&] {
    impl_->InsertPose(note, record);
    json hashes = json::array();
    for (const Exposure& exposure : record.exposures) {
      hashes.push_back(
          impl_->InsertExposure(note.pose, static_cast<int>(hashes.size()) + 1, exposure));
    }
    impl_->InsertEvent(record.end, "pose_measured",
                       {{"pose", note.pose},
                        {"candidate", note.proposal.candidate},
                        {"reason", note.proposal.reason},
                        {"frames", record.exposures.size()},
                        {"frames_wanted", note.proposal.frames},
                        {"frames_sha256", hashes},
                        {"move_retries", record.move_retries},
                        {"commanded_rad", record.commanded},
                        {"readback_rad", record.readback},
                        {"after", ToJson(note.after)}});
  });
}

Result<void> EventLog::AppendSamples(int pose, Seconds time,
                                     const std::vector<ReducedSample>& samples) {
  return impl_->Write([&] {
    int part = 0;
    json budgets = json::array();
    for (const ReducedSample& sample : samples) {
      impl_->InsertSample(pose, ++part, sample);
      budgets.push_back(BudgetOf(sample));
    }
    impl_->InsertEvent(time, "pose_reduced", {{"pose", pose}, {"sigma_per_sr", budgets}});
  });
}

Result<void> EventLog::AppendRejection(Seconds time, const RejectionNote& note) {
  json body = DegreesOf(ToHalfDiff(note.proposal.directions));
  body["candidate"] = note.proposal.candidate;
  body["reason"] = note.proposal.reason;
  body["frames_wanted"] = note.proposal.frames;
  body["message"] = note.error.message;
  body["after"] = ToJson(note.after);
  return impl_->Write([&] { impl_->InsertEvent(time, "pose_rejected", body); });
}

Result<void> EventLog::AppendResume(Seconds time, const ResumeNote& note) {
  return impl_->Write([&] {
    impl_->InsertEvent(time, "session_resumed",
                       {{"utc", UtcText(std::time(nullptr))},
                        {"gonio_version", note.gonio_version},
                        {"poses", note.poses},
                        {"changes", note.changes},
                        {"now", note.now}});
  });
}

Result<void> EventLog::AppendResumeReference(Seconds time, const ReferenceNote& note) {
  const auto rgb = [](const Rgb& v) { return json{v[0], v[1], v[2]}; };
  return impl_->Write([&] {
    impl_->InsertEvent(time, "resume_reference",
                       {{"pose", note.pose},
                        {"f_r_before", rgb(note.before.f_r)},
                        {"f_r_now", rgb(note.now.f_r)},
                        {"sigma_now", rgb(note.now.sigma)},
                        {"change", note.change},
                        {"sigma_change", note.sigma_change}});
  });
}

Result<void> EventLog::AppendReference(const ReferenceRecord& visit, const MeasurerState& after) {
  json body = BodyOf(visit);
  body["after"] = ToJson(after);
  return impl_->Write([&] { impl_->InsertEvent(visit.record.end, "reference", body); });
}

Result<void> EventLog::AppendError(Seconds time, const Error& error) {
  return impl_->Write([&] {
    impl_->InsertEvent(time, "error", {{"code", ToString(error.code)}, {"message", error.message}});
  });
}

Result<void> EventLog::AppendNote(Seconds time, const std::string& kind,
                                  const std::string& message) {
  return impl_->Write([&] { impl_->InsertEvent(time, kind, {{"message", message}}); });
}

Result<void> EventLog::AppendEnd(Seconds time, const SessionEnd& end) {
  json body = {{"outcome", end.outcome},
               {"reason", end.reason},
               {"poses", end.poses},
               {"rejected", end.rejected},
               {"duration_s", end.duration.count()}};
  if (end.predicted_error) body["predicted_error"] = *end.predicted_error;
  return impl_->Write([&] { impl_->InsertEvent(time, "session_end", body); });
}

Result<void> EventLog::AppendTogether(const std::function<Result<void>()>& append) {
  return impl_->Write([&] {
    struct Together {
      bool& on;
      ~Together() { on = false; }
    } const together{impl_->together = true};
    const Result<void> appended = append();
    if (!appended.ok()) throw sqlite::Failure(appended.error().message);
  });
}

const std::filesystem::path& EventLog::file() const { return impl_->db.file(); }

}  // namespace gonio
