// SPDX-License-Identifier: Apache-2.0
// Rows of numbers in a CSV file, and complaints that name the file, the line and the column.

#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gonio {

// A column of a file's header; empty where the file does not have it.
struct CsvColumn {
  std::string name;
  std::optional<std::size_t> index = std::nullopt;

  explicit operator bool() const { return index.has_value(); }
};

// Reads one row after the other. Lines that start with '#' are comments, blank ones are skipped.
// The first row is the header; every row has as many cells. Cells may be quoted and padded with
// blanks (a comma inside quotes still separates), lines may end in CR LF, and a byte order mark is
// skipped: spreadsheets like all of these.
//
// Everything throws ConfigError "FILE:12: column f_r_red: is "abc", must be a finite number", or
// likewise.
class CsvReader {
 public:
  // Reads the header. `text` must outlive it; `name` stands for the file in messages.
  CsvReader(std::string_view text, std::string name);

  // The column with this name, if the file has it; must not stand twice.
  CsvColumn Find(const std::string& name) const;
  CsvColumn Require(const std::string& name) const;

  // Moves to the next row; false at the end.
  bool Next();

  std::string_view Cell(const CsvColumn& column) const { return cells_[*column.index]; }
  // Any number that C++ can write, infinities and NaN included; empty if it is none.
  std::optional<double> Number(const CsvColumn& column) const;
  double Finite(const CsvColumn& column) const;
  int Whole(const CsvColumn& column) const;

  // About the row that was read last.
  [[noreturn]] void Fail(const std::string& complaint) const;
  [[noreturn]] void FailAt(const CsvColumn& column, const std::string& complaint) const;
  const std::string& name() const { return name_; }

 private:
  bool NextLine();

  std::string_view rest_;
  std::string name_;
  int line_ = 0;
  std::vector<std::string_view> header_;
  std::vector<std::string_view> cells_;
};

// Without the blanks around it.
std::string_view Trimmed(std::string_view text);
// The whole of `text` as a number, a leading '+' allowed; empty if it is none.
std::optional<double> ParseDouble(std::string_view text);

}  // namespace gonio
