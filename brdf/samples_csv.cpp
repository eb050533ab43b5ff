// SPDX-License-Identifier: Apache-2.0
#include "brdf/samples_csv.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "brdf/csv_reader.h"
#include "core/check.h"
#include "core/error.h"
#include "core/file.h"
#include "core/units.h"

namespace gonio {
namespace {

constexpr const char* kColumns =
    "pose,theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,theta_h_deg,theta_d_deg,phi_d_deg,"
    "f_r_red,f_r_green,f_r_blue,sigma_red,sigma_green,sigma_blue,time_s";

constexpr double kHorizon = kPi / 2;

// An angle's column, in degrees or radians.
struct AngleColumn {
  CsvColumn column;
  double unit = 1;  // radians

  explicit operator bool() const { return bool(column); }
  bool radians() const { return unit == 1; }
};

AngleColumn FindAngle(const CsvReader& csv, const std::string& angle) {
  const AngleColumn deg{csv.Find(angle + "_deg"), RadFromDeg(1)};
  const AngleColumn rad{csv.Find(angle + "_rad"), 1};
  if (deg && rad) csv.Fail(fmt::format("columns {0}_deg and {0}_rad: one has to do", angle));
  return rad ? rad : deg;
}

AngleColumn RequireAngle(const CsvReader& csv, const std::string& angle) {
  AngleColumn found = FindAngle(csv, angle);
  if (!found) csv.Fail(fmt::format("column {}_deg is missing", angle));
  return found;
}

// The three columns of a quantity, or one that counts for all of them.
std::array<CsvColumn, kChannels> FindChannels(const CsvReader& csv, const std::string& quantity) {
  std::array<CsvColumn, kChannels> columns;
  const CsvColumn grey = csv.Find(quantity);
  for (int c = 0; c < kChannels; ++c) {
    columns[c] = csv.Find(fmt::format("{}_{}", quantity, kChannelNames[c]));
    if (columns[c] && grey) {
      csv.Fail(fmt::format("columns {} and {}: one has to do", grey.name, columns[c].name));
    }
    if (grey) columns[c] = grey;
  }
  return columns;
}

class Reader {
 public:
  Reader(const std::string& text, const std::string& name) : csv_(text, name) {
    theta_i_ = FindAngle(csv_, "theta_i");
    theta_h_ = FindAngle(csv_, "theta_h");
    if (theta_i_ || !theta_h_) {
      FindDirections();
    } else {
      theta_d_ = RequireAngle(csv_, "theta_d");
      phi_d_ = RequireAngle(csv_, "phi_d");
    }
    for (const CsvColumn& column : f_r_) {
      if (!column) csv_.Fail(fmt::format("column {} is missing", column.name));
    }
  }

  std::vector<MeasuredSample> Read() {
    std::vector<MeasuredSample> samples;
    while (csv_.Next()) samples.push_back(ReadSample(static_cast<int>(samples.size())));
    if (samples.empty()) throw ConfigError(csv_.name() + ": holds no samples");
    return samples;
  }

 private:
  void FindDirections() {
    theta_i_ = RequireAngle(csv_, "theta_i");
    phi_ = FindAngle(csv_, "phi");
    if (!phi_) phi_i_ = RequireAngle(csv_, "phi_i");
    theta_o_ = RequireAngle(csv_, "theta_o");
    if (!phi_) phi_o_ = RequireAngle(csv_, "phi_o");
  }

  double Angle(const AngleColumn& angle) const { return angle.unit * csv_.Finite(angle.column); }

  // An arm that has passed the normal is on the other side.
  Eigen::Vector3d Direction(const AngleColumn& theta, double phi) const {
    const double polar = Angle(theta);
    if (!(std::abs(polar) < kHorizon)) {
      csv_.FailAt(theta.column,
                  fmt::format("must be within {}; the direction lies below the horizon",
                              theta.radians() ? "-pi/2 .. pi/2" : "-90 .. 90"));
    }
    return FromSpherical(polar, phi);
  }

  DirectionPair Directions() const {
    if (theta_i_ && phi_) return {Direction(theta_i_, 0), Direction(theta_o_, Angle(phi_))};
    if (theta_i_) {
      return {Direction(theta_i_, Angle(phi_i_)), Direction(theta_o_, Angle(phi_o_))};
    }
    const double theta_h = Angle(theta_h_);
    const double theta_d = Angle(theta_d_);
    if (theta_h < 0) csv_.FailAt(theta_h_.column, "must be >= 0");
    if (theta_d < 0) csv_.FailAt(theta_d_.column, "must be >= 0");
    const DirectionPair pair = ToDirections({theta_h, theta_d, Angle(phi_d_)});
    if (theta_h >= kHorizon || theta_d >= kHorizon || !pair.above_horizon()) {
      csv_.FailAt(theta_h_.column,
                  "with this theta_d and phi_d a direction lies below the horizon");
    }
    return pair;
  }

  double Sigma(const CsvColumn& column, double f_r) const {
    if (!column) return kDefaultRelativeSigma * std::abs(f_r) + kDefaultSigmaFloor;
    const auto number = csv_.Number(column);
    if (!number || !(*number > 0)) csv_.FailAt(column, "must be a number > 0, or inf");
    return *number;
  }

  MeasuredSample ReadSample(int row) const {
    MeasuredSample measured{.pose = pose_ ? csv_.Whole(pose_) : row, .sample = {}};
    measured.sample.directions = Directions();
    for (int c = 0; c < kChannels; ++c) {
      measured.sample.f_r[c] = csv_.Finite(f_r_[c]);
      measured.sample.sigma[c] = Sigma(sigma_[c], measured.sample.f_r[c]);
    }
    if (time_) measured.time_s = csv_.Finite(time_);
    return measured;
  }

  CsvReader csv_;
  // Either the first four or, in place of the azimuths, phi_; or the last three.
  AngleColumn theta_i_, phi_i_, theta_o_, phi_o_, phi_;
  AngleColumn theta_h_, theta_d_, phi_d_;
  const CsvColumn pose_ = csv_.Find("pose");
  const CsvColumn time_ = csv_.Find("time_s");
  const std::array<CsvColumn, kChannels> f_r_ = FindChannels(csv_, "f_r");
  const std::array<CsvColumn, kChannels> sigma_ = FindChannels(csv_, "sigma");
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
