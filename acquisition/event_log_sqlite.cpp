// SPDX-License-Identifier: Apache-2.0
#include "acquisition/event_log_sqlite.h"

#include <fmt/format.h>

#include <system_error>

namespace gonio::sqlite {

Database::Database(const std::filesystem::path& file, int flags) : file_(file) {
  sqlite3* db = nullptr;
  const int status = sqlite3_open_v2(file.c_str(), &db, flags, nullptr);
  db_.reset(db);
  if (status != SQLITE_OK) Fail("open");
  sqlite3_extended_result_codes(db, 1);
  sqlite3_busy_timeout(db, 2000);
}

void Database::Execute(const char* sql) {
  if (sqlite3_exec(db_.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) Fail("write");
}

void Database::Fail(std::string_view action) const {
  if (db_ == nullptr)
    throw Failure(fmt::format("{}: cannot {}: out of memory", file_.string(), action));
  std::string reason = sqlite3_errmsg(db_.get());
  const int code = sqlite3_errcode(db_.get()) & 0xff;
  const int system_error = sqlite3_system_errno(db_.get());
  // "disk I/O error" alone helps nobody; the operating system said more.
  if ((code == SQLITE_IOERR || code == SQLITE_CANTOPEN) && system_error != 0) {
    reason += fmt::format(" ({})", std::generic_category().message(system_error));
  }
  const int extended = sqlite3_extended_errcode(db_.get());
  if (extended == SQLITE_READONLY_ROLLBACK || extended == SQLITE_READONLY_RECOVERY) {
    reason = "was not closed; gonio run --resume, which may write to it, mends that";
  }
  throw Failure(fmt::format("{}: cannot {}: {}", file_.string(), action, reason));
}

Statement::Statement(Database& db, const char* sql) : db_(&db) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(db.get(), sql, -1, &statement, nullptr) != SQLITE_OK) db.Fail("read");
  statement_.reset(statement);
}

void Statement::BindRow(const Statement& row) {
  const int columns = sqlite3_column_count(row.statement_.get());
  for (int i = 0; i < columns; ++i) {
    sqlite3_value* const value = sqlite3_column_value(row.statement_.get(), i);
    if (sqlite3_bind_value(statement_.get(), i + 1, value) != SQLITE_OK) db_->Fail("write");
  }
}

bool Statement::Step() {
  const int status = sqlite3_step(statement_.get());
  if (status == SQLITE_ROW) return true;
  if (status == SQLITE_DONE) return false;
  db_->Fail(sqlite3_stmt_readonly(statement_.get()) != 0 ? "read" : "write");
}

void Statement::Reset() {
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
}

std::span<const std::uint8_t> Statement::Bytes(int column) const {
  const auto* const data =
      static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_.get(), column));
  return {data, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

std::string Statement::Text(int column) const {
  const unsigned char* text = sqlite3_column_text(statement_.get(), column);
  return text == nullptr ? std::string() : reinterpret_cast<const char*>(text);
}

void Statement::BindOne(int index, double number) {
  if (sqlite3_bind_double(statement_.get(), index, number) != SQLITE_OK) db_->Fail("write");
}

void Statement::BindOne(int index, std::int64_t number) {
  if (sqlite3_bind_int64(statement_.get(), index, number) != SQLITE_OK) db_->Fail("write");
}

void Statement::BindOne(int index, const std::string& text) {
  if (sqlite3_bind_text64(statement_.get(), index, text.data(), text.size(), SQLITE_TRANSIENT,
                          SQLITE_UTF8) != SQLITE_OK) {
    db_->Fail("write");
  }
}

void Statement::BindOne(int index, std::span<const std::uint8_t> bytes) {
  if (sqlite3_bind_blob64(statement_.get(), index, bytes.data(), bytes.size(), SQLITE_STATIC) !=
      SQLITE_OK) {
    db_->Fail("write");
  }
}

void Statement::BindOne(int index, const std::optional<std::string>& text) {
  if (text) {
    BindOne(index, *text);
  } else {
    BindOne(index, std::optional<double>());
  }
}

void Statement::BindOne(int index, const std::optional<double>& number) {
  if (number) {
    BindOne(index, *number);
  } else if (sqlite3_bind_null(statement_.get(), index) != SQLITE_OK) {
    db_->Fail("write");
  }
}

Transaction::~Transaction() {
  // After some errors SQLite has rolled back by itself; a second ROLLBACK then fails harmlessly.
  if (db_ != nullptr) sqlite3_exec(db_->get(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::Commit() {
  db_->Execute("COMMIT");
  db_ = nullptr;
}

}  // namespace gonio::sqlite
