// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session_check.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "acquisition/event_log.h"
#include "acquisition/event_log_sqlite.h"
#include "acquisition/session_format.h"
#include "acquisition/session_record.h"
#include "core/error.h"
#include "core/sha256.h"

namespace gonio {
namespace {

using nlohmann::json;

// Of one kind of damage.
constexpr int kShown = 5;

class Check {
 public:
  explicit Check(const std::filesystem::path& session)
      : db_(session / kSessionFile, SQLITE_OPEN_READONLY) {
    SessionVersion(db_);
  }

  std::vector<std::string> Run() {
    Guarded([&] { Pages(); });
    Guarded([&] { References(); });
    Guarded([&] { Events(); });
    return std::move(damage_);
  }

 private:
  // What cannot be read is damage, too.
  template <typename Body>
  void Guarded(const Body& body) {
    try {
      body();
    } catch (const sqlite::Failure& e) {
      damage_.emplace_back(e.what());
    } catch (const json::exception& e) {
      damage_.emplace_back(fmt::format("an event cannot be read: {}", e.what()));
    }
  }

  void Pages() {
    sqlite::Statement check(db_, fmt::format("PRAGMA quick_check({})", kShown).c_str());
    while (check.Step()) {
      if (check.Text(0) != "ok") damage_.push_back(check.Text(0));
    }
  }

  void References() {
    sqlite::Statement check(db_, "PRAGMA foreign_key_check");
    for (int n = 0; check.Step() && n < kShown; ++n) {
      damage_.push_back(fmt::format("{}: row {} belongs to no {}", check.Text(0), check.Integer(1),
                                    check.Text(2)));
    }
  }

  void Events() {
    std::int64_t expected = 1;
    sqlite::Statement row(db_, "SELECT seq, kind, body FROM events ORDER BY seq");
    for (; row.Step(); ++expected) {
      if (row.Integer(0) != expected) {
        damage_.push_back(fmt::format("events {} to {} are missing", expected, row.Integer(0) - 1));
        expected = row.Integer(0);
      }
      if (row.Text(1) == "pose_measured") Pose(json::parse(row.Text(2)));
    }
  }

  void Pose(const json& body) {
    if (!body.contains("frames_sha256")) return;  // an older session
    const int pose = body.at("pose").get<int>();
    sqlite::Statement row(db_, "SELECT counts FROM exposures WHERE pose = ? ORDER BY frame");
    row.Bind(pose);
    std::size_t frame = 0;
    for (const std::string hash : body["frames_sha256"]) {
      ++frame;
      if (!row.Step()) {
        damage_.push_back(fmt::format("pose {}: frame {} is missing", pose, frame));
        return;
      }
      const auto bytes = row.Bytes(0);
      const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      if (Sha256(text) == hash) continue;
      damage_.push_back(fmt::format("pose {}: frame {} is not what was written", pose, frame));
    }
  }

  sqlite::Database db_;
  std::vector<std::string> damage_;
};

}  // namespace

std::vector<std::string> FindDamage(const std::filesystem::path& session) {
  CheckSession(session);
  try {
    return Check(session).Run();
  } catch (const sqlite::Failure& e) {
    throw ConfigError(e.what());
  }
}

}  // namespace gonio
