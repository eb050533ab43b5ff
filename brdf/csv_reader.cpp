// SPDX-License-Identifier: Apache-2.0
#include "brdf/csv_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/error.h"

namespace gonio {
namespace {

std::vector<std::string_view> Split(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t comma = line.find(',');
    std::string_view cell = Trimmed(line.substr(0, comma));
    if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') {
      cell = Trimmed(cell.substr(1, cell.size() - 2));
    }
    cells.push_back(cell);
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

template <typename N>
std::optional<N> Parse(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  N number{};
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc{} || stopped != end) return std::nullopt;
  return number;
}

}  // namespace

std::string_view Trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::optional<double> ParseDouble(std::string_view text) { return Parse<double>(text); }

CsvReader::CsvReader(std::string_view text, std::string name)
    : rest_(text), name_(std::move(name)) {
  if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
  if (!NextLine()) throw ConfigError(name_ + ": holds no header row");
  header_ = cells_;
}

CsvColumn CsvReader::Find(const std::string& name) const {
  const auto found = std::find(header_.begin(), header_.end(), name);
  if (found == header_.end()) return {name};
  if (std::find(found + 1, header_.end(), name) != header_.end()) {
    Fail(fmt::format("column {} stands twice", name));
  }
  return {name, static_cast<std::size_t>(found - header_.begin())};
}

CsvColumn CsvReader::Require(const std::string& name) const {
  CsvColumn column = Find(name);
  if (!column) Fail(fmt::format("column {} is missing", name));
  return column;
}

bool CsvReader::Next() {
  if (!NextLine()) return false;
  if (cells_.size() != header_.size()) {
    Fail(fmt::format("has {} cells, the header has {}", cells_.size(), header_.size()));
  }
  return true;
}

bool CsvReader::NextLine() {
  while (!rest_.empty()) {
    const std::size_t end = rest_.find('\n');
    const std::string_view line = Trimmed(rest_.substr(0, end));
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++line_;
    if (line.empty() || line.starts_with('#')) continue;
    cells_ = Split(line);
    return true;
  }
  return false;
}

std::optional<double> CsvReader::Number(const CsvColumn& column) const {
  return ParseDouble(Cell(column));
}

double CsvReader::Finite(const CsvColumn& column) const {
  const auto number = Number(column);
  if (!number || !std::isfinite(*number)) FailAt(column, "must be a finite number");
  return *number;
}

int CsvReader::Whole(const CsvColumn& column) const {
  const auto number = Parse<int>(Cell(column));
  if (!number) FailAt(column, "must be a whole number");
  return *number;
}

void CsvReader::Fail(const std::string& complaint) const {
  throw ConfigError(fmt::format("{}:{}: {}", name_, line_, complaint));
}

void CsvReader::FailAt(const CsvColumn& column, const std::string& complaint) const {
  Fail(fmt::format("column {}: is \"{}\", {}", column.name, Cell(column), complaint));
}

}  // namespace gonio
