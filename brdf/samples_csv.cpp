// SPDX-License-Identifier: Apache-2.0
#include "brdf/samples_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "core/check.h"
#include "core/error.h"
#include "core/file.h"
#include "core/units.h"

namespace gonio {
namespace {

constexpr const char* kColumns =
    "pose,theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,theta_h_deg,theta_d_deg,phi_d_deg,"
    "f_r_red,f_r_green,f_r_blue,sigma_red,sigma_green,sigma_blue,time_s";

std::string_view Trim(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> Split(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t comma = line.find(',');
    std::string_view cell = Trim(line.substr(0, comma));
    if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') {
      cell = Trim(cell.substr(1, cell.size() - 2));
    }
    cells.push_back(cell);
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

template <typename Number>
std::optional<Number> ParseNumber(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc{} || stopped != end) return std::nullopt;
  return number;
}

class Reader {
 public:
  Reader(const std::string& text, const std::string& name) : rest_(text), name_(name) {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
  }

  std::vector<MeasuredSample> Read() {
    if (!NextRow()) throw ConfigError(name_ + ": holds no header row");
    ReadHeader();
    std::vector<MeasuredSample> samples;
    while (NextRow()) {
      if (cells_.size() != header_size_) {
        Fail(fmt::format("has {} cells, the header has {}", cells_.size(), header_size_));
      }
      samples.push_back(ReadSample(static_cast<int>(samples.size())));
    }
    if (samples.empty()) throw ConfigError(name_ + ": holds no samples");
    return samples;
  }

 private:
  // A column that we know, and where the file has it.
  struct Column {
    std::string name;
    bool required = false;
    std::optional<std::size_t> index = std::nullopt;
  };

  [[noreturn]] void Fail(const std::string& complaint) const {
    throw ConfigError(fmt::format("{}:{}: {}", name_, line_, complaint));
  }

  [[noreturn]] void FailAt(const Column& column, std::string_view complaint) const {
    Fail(fmt::format("column {}: is \"{}\", {}", column.name, Cell(column), complaint));
  }

  std::string_view Cell(const Column& column) const { return cells_[*column.index]; }

  // Moves to the next line that is neither blank nor a comment; false at the end.
  bool NextRow() {
    while (!rest_.empty()) {
      const std::size_t end = rest_.find('\n');
      const std::string_view line = Trim(rest_.substr(0, end));
      rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
      ++line_;
      if (line.empty() || line.starts_with('#')) continue;
      cells_ = Split(line);
      return true;
    }
    return false;
  }

  void ReadHeader() {
    header_size_ = cells_.size();
    std::vector<Column*> known = {&pose_, &theta_i_, &phi_i_, &theta_o_, &phi_o_, &time_};
    for (int c = 0; c < kChannels; ++c) {
      f_r_[c] = {fmt::format("f_r_{}", kChannelNames[c]), true};
      sigma_[c] = {fmt::format("sigma_{}", kChannelNames[c])};
      known.insert(known.end(), {&f_r_[c], &sigma_[c]});
    }
    for (Column* column : known) {
      const auto found = std::find(cells_.begin(), cells_.end(), column->name);
      if (found == cells_.end()) {
        if (column->required) Fail(fmt::format("column {} is missing", column->name));
        continue;
      }
      if (std::find(found + 1, cells_.end(), column->name) != cells_.end()) {
        Fail(fmt::format("column {} stands twice", column->name));
      }
      column->index = static_cast<std::size_t>(found - cells_.begin());
    }
  }

  double Finite(const Column& column) const {
    const auto number = ParseNumber<double>(Cell(column));
    if (!number || !std::isfinite(*number)) FailAt(column, "must be a finite number");
    return *number;
  }

  Eigen::Vector3d Direction(const Column& theta, const Column& phi) const {
    const double deg = Finite(theta);
    if (deg < 0) FailAt(theta, "must be >= 0; for the other side, add 180 to phi");
    if (deg >= 90) FailAt(theta, "must be < 90; the direction lies below the horizon");
    return FromSpherical(RadFromDeg(deg), RadFromDeg(Finite(phi)));
  }

  double Sigma(const Column& column, double f_r) const {
    if (!column.index) return kDefaultRelativeSigma * std::abs(f_r) + kDefaultSigmaFloor;
    const auto number = ParseNumber<double>(Cell(column));
    if (!number || !(*number > 0)) FailAt(column, "must be a number > 0, or inf");
    return *number;
  }

  MeasuredSample ReadSample(int row) const {
    MeasuredSample measured{.pose = row, .sample = {}};
    if (pose_.index) {
      const auto number = ParseNumber<int>(Cell(pose_));
      if (!number) FailAt(pose_, "must be a whole number");
      measured.pose = *number;
    }
    measured.sample.directions = {Direction(theta_i_, phi_i_), Direction(theta_o_, phi_o_)};
    for (int c = 0; c < kChannels; ++c) {
      measured.sample.f_r[c] = Finite(f_r_[c]);
      measured.sample.sigma[c] = Sigma(sigma_[c], measured.sample.f_r[c]);
    }
    if (time_.index) measured.time_s = Finite(time_);
    return measured;
  }

  std::string_view rest_;
  const std::string& name_;
  int line_ = 0;
  std::vector<std::string_view> cells_;
  std::size_t header_size_ = 0;
  Column pose_{"pose"}, time_{"time_s"};
  Column theta_i_{"theta_i_deg", true}, phi_i_{"phi_i_deg", true};
  Column theta_o_{"theta_o_deg", true}, phi_o_{"phi_o_deg", true};
  std::array<Column, kChannels> f_r_, sigma_;
};

double PolarDeg(const Eigen::Vector3d& w) {
  return DegFromRad(std::atan2(std::hypot(w.x(), w.y()), w.z()));
}

double AzimuthDeg(const Eigen::Vector3d& w) { return DegFromRad(std::atan2(w.y(), w.x())); }

std::string FormatRow(const MeasuredSample& measured) {
  const BrdfSample& sample = measured.sample;
  const DirectionPair& pair = sample.directions;
  const HalfDiff angles = ToHalfDiff(pair);
  Rgb f_r = sample.f_r;
  for (int c = 0; c < kChannels; ++c) {
    if (std::isfinite(f_r[c])) continue;
    GONIO_CHECK(std::isinf(sample.sigma[c]), fmt::format("pose {}: f_r {}", measured.pose, f_r[c]));
    f_r[c] = 0;
  }
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", measured.pose,
                     PolarDeg(pair.wi), AzimuthDeg(pair.wi), PolarDeg(pair.wo), AzimuthDeg(pair.wo),
                     DegFromRad(angles.theta_h), DegFromRad(angles.theta_d),
                     DegFromRad(angles.phi_d), f_r[0], f_r[1], f_r[2], sample.sigma[0],
                     sample.sigma[1], sample.sigma[2], measured.time_s);
}

}  // namespace

std::vector<MeasuredSample> ReadSamplesCsv(const std::filesystem::path& path) {
  return ParseSamplesCsv(ReadTextFile(path), path.string());
}

std::vector<MeasuredSample> ParseSamplesCsv(const std::string& text, const std::string& name) {
  return Reader(text, name).Read();
}

void WriteSamplesCsv(const std::filesystem::path& path, const std::vector<MeasuredSample>& samples,
                     const std::vector<std::string>& comments) {
  std::string text;
  for (const std::string& comment : comments) text += fmt::format("# {}\n", comment);
  text += fmt::format("{}\n", kColumns);
  for (const MeasuredSample& measured : samples) text += FormatRow(measured);
  WriteFileAtomically(path, [&text](std::ostream& out) { out << text; });
}

}  // namespace gonio
