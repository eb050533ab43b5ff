// SPDX-License-Identifier: Apache-2.0
// What every reader of a session asks first; private to those that have its database.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "acquisition/event_log_sqlite.h"

namespace gonio {

// The version of its tables. Throws ConfigError: it is no session, or of a version we do not know.
std::int64_t SessionVersion(sqlite::Database& db);
// That, and SQLite finds no page damaged. Throws ConfigError.
std::int64_t CheckSessionFormat(sqlite::Database& db);

// An empty session of a rig with these axes (acquisition/rig_kind.h): its tables, and the triggers
// that keep what is in them.
void CreateSessionTables(sqlite::Database& db, const std::vector<std::string>& axes);
// What that was called with.
std::vector<std::string> AxesIn(sqlite::Database& db);

// The columns of `poses` that hold positions, in order: commanded of each axis, then readback.
std::vector<std::string> PositionColumns(const std::vector<std::string>& axes);

// Gives a session of format kOldestResumedFormat the tables of this one. What is in it stays.
void BringSessionUpToDate(sqlite::Database& db);

}  // namespace gonio
