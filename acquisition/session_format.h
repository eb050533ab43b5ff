// SPDX-License-Identifier: Apache-2.0
// What every reader of a session asks first; private to those that have its database.

#pragma once

#include <cstdint>

#include "acquisition/event_log_sqlite.h"

namespace gonio {

// The version of its tables. Throws ConfigError: it is no session, or of a version we do not know.
std::int64_t SessionVersion(sqlite::Database& db);
// That, and SQLite finds no page damaged. Throws ConfigError.
std::int64_t CheckSessionFormat(sqlite::Database& db);

// An empty session: its tables, and the triggers that keep what is in them.
void CreateSessionTables(sqlite::Database& db);

// Gives a session of format kOldestResumedFormat the tables of this one. What is in it stays.
void BringSessionUpToDate(sqlite::Database& db);

}  // namespace gonio
