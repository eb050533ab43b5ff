// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session_format.h"

#include <fmt/format.h>

#include <string>

#include "acquisition/event_log.h"
#include "acquisition/event_log_schema.h"
#include "core/error.h"

namespace gonio {
namespace {

// Of the columns that hold positions of the axes.
const std::string kCommanded = "commanded_";
const std::string kDegrees = "_deg";

std::int64_t Pragma(sqlite::Database& db, const char* name) {
  sqlite::Statement statement(db, fmt::format("PRAGMA {}", name).c_str());
  return statement.Step() ? statement.Integer(0) : 0;
}

// Its first transaction was not made.
bool IsEmpty(sqlite::Database& db) {
  sqlite::Statement tables(db, "SELECT count(*) FROM sqlite_schema");
  return tables.Step() && tables.Integer(0) == 0;
}

}  // namespace

std::int64_t SessionVersion(sqlite::Database& db) {
  const std::string file = db.file().string();
  const std::int64_t application = Pragma(db, "application_id");
  if (application == 0 && IsEmpty(db)) {
    throw ConfigError(file +
                      ": holds nothing yet: its session was ended while it was made; remove the "
                      "directory and begin anew");
  }
  if (application != kSessionApplicationId) {
    throw ConfigError(file + ": is not a session: some other program made this database");
  }
  const std::int64_t version = Pragma(db, "user_version");
  if (version < kOldestSessionFormat || version > kSessionFormat) {
    throw ConfigError(fmt::format("{}: has session format {}, this program reads formats {} to {}",
                                  file, version, kOldestSessionFormat, kSessionFormat));
  }
  return version;
}

std::int64_t CheckSessionFormat(sqlite::Database& db) {
  const std::int64_t version = SessionVersion(db);
  sqlite::Statement check(db, "PRAGMA quick_check(1)");
  if (!check.Step() || check.Text(0) != "ok") {
    throw ConfigError(fmt::format("{}: is damaged: {} (gonio rescue keeps what is whole)",
                                  db.file().string(), check.Text(0)));
  }
  return version;
}

std::vector<std::string> PositionColumns(const std::vector<std::string>& axes) {
  std::vector<std::string> columns;
  for (const std::string& which : {kCommanded, std::string("readback_")}) {
    for (const std::string& axis : axes) columns.push_back(which + axis + kDegrees);
  }
  return columns;
}

std::vector<std::string> AxesIn(sqlite::Database& db) {
  std::vector<std::string> axes;
  sqlite::Statement column(db, "SELECT name FROM pragma_table_info('poses') ORDER BY cid");
  while (column.Step()) {
    const std::string name = column.Text(0);
    if (!name.starts_with(kCommanded) || !name.ends_with(kDegrees)) continue;
    axes.push_back(
        name.substr(kCommanded.size(), name.size() - kCommanded.size() - kDegrees.size()));
  }
  return axes;
}

void CreateSessionTables(sqlite::Database& db, const std::vector<std::string>& axes) {
  constexpr std::string_view kPlace = "@axes@";
  std::string columns;
  for (const std::string& name : PositionColumns(axes))
    columns += "  " + name + " REAL NOT NULL,\n";
  std::string schema = kSessionSchema;
  schema.replace(schema.find(kPlace), kPlace.size(), columns);
  db.Execute(schema.c_str());
  constexpr const char* kRefuse =
      "CREATE TRIGGER {0}_refuse_{1} BEFORE {1} ON {0} {2} BEGIN SELECT RAISE(ABORT, '{0} is "
      "append-only'); END";
  for (const auto& [table, same_key] : kSessionTables) {
    const std::string replaces =
        fmt::format("WHEN EXISTS (SELECT 1 FROM {} WHERE {})", table, same_key);
    db.Execute(fmt::format(kRefuse, table, "UPDATE", "").c_str());
    db.Execute(fmt::format(kRefuse, table, "DELETE", "").c_str());
    db.Execute(fmt::format(kRefuse, table, "INSERT", replaces).c_str());
  }
  db.Execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}",
                         kSessionApplicationId, kSessionFormat)
                 .c_str());
}

void BringSessionUpToDate(sqlite::Database& db) {
  sqlite::Transaction transaction(db);
  db.Execute("ALTER TABLE exposures ADD COLUMN colour TEXT");
  db.Execute(fmt::format("PRAGMA user_version = {}", kSessionFormat).c_str());
  transaction.Commit();
}

}  // namespace gonio
