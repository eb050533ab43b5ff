// SPDX-License-Identifier: Apache-2.0
// SQLite's C interface in RAII; private to event_log.cpp and session_record.cpp.

#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace gonio::sqlite {

// SQLite refused; what() is "FILE: cannot ACTION: REASON", one line.
class Failure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// One connection; closed by the destructor.
class Database {
 public:
  // flags as sqlite3_open_v2(). Throws Failure.
  Database(const std::filesystem::path& file, int flags);

  // Runs statements that return no rows. Throws Failure.
  void Execute(const char* sql);

  [[noreturn]] void Fail(std::string_view action) const;
  sqlite3* get() const { return db_.get(); }
  const std::filesystem::path& file() const { return file_; }

 private:
  struct Close {
    void operator()(sqlite3* db) const { sqlite3_close_v2(db); }
  };
  std::filesystem::path file_;
  std::unique_ptr<sqlite3, Close> db_;
};

// One prepared statement. Parameters are bound in order by Bind(a, b, ...), columns read by index.
//
//   Statement insert(db, "INSERT INTO t VALUES (?, ?)");
//   insert.Run(1, "text");                 // binds, steps to the end, resets
//   Statement all(db, "SELECT a FROM t");
//   while (all.Step()) all.Real(0);
class Statement {
 public:
  Statement(Database& db, const char* sql);

  // A span of doubles fills as many parameters.
  template <typename... Values>
  void Bind(const Values&... values) {
    Reset();
    int index = 0;
    (BindNext(index, values), ...);
  }
  template <typename... Values>
  void Run(const Values&... values) {
    Bind(values...);
    while (Step()) {
    }
    Reset();
  }

  // Every column of the row that `row` is at; then another number in the first of them.
  void BindRow(const Statement& row);
  void BindFirst(int number) { BindOne(1, number); }

  // True while there is a row. Throws Failure.
  bool Step();
  void Reset();

  double Real(int column) const { return sqlite3_column_double(statement_.get(), column); }
  std::int64_t Integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }
  bool IsNull(int column) const {
    return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL;
  }
  std::string Text(int column) const;
  std::span<const std::uint8_t> Bytes(int column) const;  // until the next Step() or Reset()

 private:
  template <typename Value>
  void BindNext(int& index, const Value& value) {
    BindOne(++index, value);
  }
  void BindNext(int& index, std::span<const double> numbers) {
    for (const double number : numbers) BindOne(++index, number);
  }
  void BindOne(int index, double number);
  void BindOne(int index, std::int64_t number);
  void BindOne(int index, int number) { BindOne(index, std::int64_t{number}); }
  void BindOne(int index, const std::string& text);
  void BindOne(int index, std::span<const std::uint8_t> bytes);  // must live until Reset()
  void BindOne(int index, const std::optional<double>& number);
  void BindOne(int index, const std::optional<std::string>& text);

  struct Finalize {
    void operator()(sqlite3_stmt* s) const { sqlite3_finalize(s); }
  };
  Database* db_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

// From BEGIN to COMMIT; rolls back unless committed.
class Transaction {
 public:
  explicit Transaction(Database& db, const char* begin = "BEGIN IMMEDIATE") : db_(&db) {
    db.Execute(begin);
  }
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void Commit();

 private:
  Database* db_;
};

}  // namespace gonio::sqlite
