// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/event_log.h"
#include "acquisition/event_log_sqlite.h"
#include "acquisition/session_check.h"
#include "acquisition/session_format.h"
#include "acquisition/session_record.h"
#include "core/error.h"
#include "core/sha256.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Numbers in a row that hold nothing, after which a table is taken to be at its end.
constexpr int kGap = 10000;

class Rescue {
 public:
  Rescue(const fs::path& from, const fs::path& to)
      : from_(from / kSessionFile, SQLITE_OPEN_READONLY),
        to_(to / kSessionFile, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE) {
    if (SessionVersion(from_) < kOldestResumedFormat) {
      throw ConfigError(from.string() + ": is of an older format, which cannot be rescued");
    }
  }

  Rescued Run() {
    sqlite::Transaction transaction(to_);
    CreateSessionTables(to_, AxesIn(from_));
    CopyMeta();
    int gap = 0;
    for (std::int64_t seq = 1; gap < kGap; ++seq) {
      gap = CopyEvent(seq) ? 0 : gap + 1;
    }
    Note();
    transaction.Commit();
    return std::move(rescued_);
  }

 private:
  // Without it nobody knows what was measured.
  void CopyMeta() {
    sqlite::Statement row(from_, "SELECT key, value FROM meta");
    sqlite::Statement insert(to_, "INSERT INTO meta VALUES (?, ?)");
    while (row.Step()) Copy(row, insert);
  }

  static void Copy(const sqlite::Statement& row, sqlite::Statement& insert) {
    insert.Reset();
    insert.BindRow(row);
    while (insert.Step()) {
    }
  }

  // False: there is none of this number. One that cannot be read is lost.
  bool CopyEvent(std::int64_t seq) {
    try {
      sqlite::Statement row(from_, "SELECT time_s, kind, body FROM events WHERE seq = ?");
      row.Bind(seq);
      if (!row.Step()) return false;
      CopyEvent(row.Real(0), row.Text(1), json::parse(row.Text(2)));
    } catch (const sqlite::Failure& e) {
      rescued_.lost.push_back(fmt::format("event {}: {}", seq, e.what()));
    } catch (const json::exception&) {
      rescued_.lost.push_back(fmt::format("event {}: cannot be read", seq));
    }
    return true;
  }

  void CopyEvent(double time, const std::string& kind, json body) {
    if (kind == "pose_measured" || kind == "pose_reduced") {
      const int pose = body.at("pose").get<int>();
      if (kind == "pose_measured") CopyPose(pose, body);
      const auto kept = numbers_.find(pose);
      if (kept == numbers_.end()) return;
      if (kind == "pose_reduced" && !CopySamples(pose, kept->second)) return;
      body["pose"] = kept->second;
    }
    sqlite::Statement(to_, "INSERT INTO events (time_s, kind, body) VALUES (?, ?, ?)")
        .Run(time, kind, body.dump());
  }

  // All of it, or none.
  void CopyPose(int pose, const json& body) {
    const int number = rescued_.poses + 1;
    to_.Execute("SAVEPOINT pose");
    const std::optional<std::string> why = WhyLost(pose, number, body);
    if (why) to_.Execute("ROLLBACK TO pose");
    to_.Execute("RELEASE pose");
    if (why) {
      ++rescued_.lost_poses;
      rescued_.lost.push_back(fmt::format("pose {}: {}", pose, *why));
      return;
    }
    ++rescued_.poses;
    numbers_[pose] = number;
  }

  // Copies; empty: it went well.
  std::optional<std::string> WhyLost(int pose, int number, const json& body) {
    try {
      if (CopyRows("poses", pose, number) != 1) return "has no row";
      const auto frames = body.at("frames_sha256").get<std::vector<std::string>>();
      if (CopyRows("exposures", pose, number) != static_cast<int>(frames.size())) {
        return "misses frames";
      }
      sqlite::Statement row(from_, "SELECT counts FROM exposures WHERE pose = ? ORDER BY frame");
      row.Bind(pose);
      for (const std::string& hash : frames) {
        if (!row.Step()) return "misses frames";
        const auto bytes = row.Bytes(0);
        if (Sha256({reinterpret_cast<const char*>(bytes.data()), bytes.size()}) != hash) {
          return "a frame is not what was written";
        }
      }
      sqlite::Statement samples(from_, "SELECT count(*) FROM samples WHERE pose = ?");
      samples.Bind(pose);
      if (!samples.Step() || (samples.Integer(0) == 0 && !IsLast(pose))) return "has no samples";
    } catch (const sqlite::Failure& e) {
      return e.what();
    }
    return std::nullopt;
  }

  bool IsLast(int pose) {
    sqlite::Statement later(from_, "SELECT 1 FROM poses WHERE pose > ?");
    later.Bind(pose);
    return !later.Step();
  }

  bool CopySamples(int pose, int number) {
    const int copied = CopyRows("samples", pose, number);
    return copied > 0;
  }

  // Of the damaged session's table, which may be of an older format than ours, or in another order.
  std::vector<std::string> ColumnsOf(const char* table) {
    std::vector<std::string> columns;
    sqlite::Statement row(from_,
                          fmt::format("SELECT name FROM pragma_table_info('{}')", table).c_str());
    while (row.Step()) columns.push_back(row.Text(0));
    return columns;
  }

  // Of a table whose first column is the pose. Returns how many.
  int CopyRows(const char* table, int pose, int number) {
    const std::vector<std::string> columns = ColumnsOf(table);
    std::string places = "?";
    for (std::size_t i = 1; i < columns.size(); ++i) places += ", ?";
    const std::string names = fmt::format("{}", fmt::join(columns, ", "));
    sqlite::Statement row(from_,
                          fmt::format("SELECT {} FROM {} WHERE pose = ?", names, table).c_str());
    sqlite::Statement insert(
        to_, fmt::format("INSERT INTO {} ({}) VALUES ({})", table, names, places).c_str());
    row.Bind(pose);
    int rows = 0;
    for (; row.Step(); ++rows) {
      insert.Reset();
      insert.BindRow(row);
      insert.BindFirst(number);
      while (insert.Step()) {
      }
    }
    return rows;
  }

  void Note() {
    sqlite::Statement last(to_, "SELECT max(time_s) FROM events");
    const double time = last.Step() ? last.Real(0) : 0;
    const json body = {{"poses", rescued_.poses}, {"lost", rescued_.lost}};
    sqlite::Statement(to_, "INSERT INTO events (time_s, kind, body) VALUES (?, ?, ?)")
        .Run(time, std::string("rescued"), body.dump());
  }

  sqlite::Database from_;
  sqlite::Database to_;
  std::map<int, int> numbers_;  // of poses: before -> now
  Rescued rescued_;
};

}  // namespace

Rescued RescueSession(const fs::path& from, const fs::path& to) {
  CheckSession(from);
  if (fs::exists(fs::symlink_status(to))) {
    throw ConfigError(to.string() + ": exists already; name another");
  }
  fs::create_directory(to);
  try {
    Rescued rescued = Rescue(from, to).Run();
    if (fs::is_directory(from / kSessionCalibration)) {
      fs::copy(from / kSessionCalibration, to / kSessionCalibration);
    }
    return rescued;
  } catch (const sqlite::Failure& e) {
    fs::remove_all(to);
    throw ConfigError(fmt::format("nothing can be kept: {}", e.what()));
  } catch (...) {
    fs::remove_all(to);
    throw;
  }
}

}  // namespace gonio
