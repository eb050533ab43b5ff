// SPDX-License-Identifier: Apache-2.0
#include "brdf/rt300s_csv.h"

#include <cmath>
#include <cstdint>
#include <optional>

#include "brdf/csv_reader.h"
#include "core/error.h"
#include "core/units.h"
#include "core/utc.h"

namespace gonio {
namespace {

class Reader {
 public:
  Reader(const std::string& text, const std::string& name) : csv_(text, name) {}

  Rt300sSession Read() {
    Rt300sSession session;
    std::optional<std::int64_t> start;
    while (csv_.Next()) {
      const std::int64_t clock = Clock();
      if (!start) {
        start = clock;
        session.started = std::string(csv_.Cell(clock_));
      }
      session.samples.push_back({.pose = static_cast<int>(session.samples.size()),
                                 .sample = ReadSample(),
                                 .time_s = static_cast<double>(clock - *start)});
    }
    if (session.samples.empty()) throw ConfigError(csv_.name() + ": holds no readings");
    return session;
  }

 private:
  // The zone is not known and does not matter to differences.
  std::int64_t Clock() const {
    const auto seconds = SecondsOfUtc(std::string(csv_.Cell(clock_)) + "Z");
    if (!seconds) csv_.FailAt(clock_, "must be like 2011-02-13T11:07:15");
    return *seconds;
  }

  double Polar(const CsvColumn& column) const {
    const double deg = csv_.Finite(column);
    if (!(std::abs(deg) < 90)) {
      csv_.FailAt(column, "must be within -90 .. 90; the direction lies below the horizon");
    }
    return RadFromDeg(deg);
  }

  BrdfSample ReadSample() const {
    const double receive = Polar(receive_);
    BrdfSample sample;
    sample.directions = {
        FromSpherical(Polar(incidence_), 0),
        FromSpherical(receive, RadFromDeg(90 - csv_.Finite(azimuth_)))};  // negative: other side
    const double reading = csv_.Finite(reading_);
    sample.f_r = Rgb::Constant(reading / std::cos(receive));
    if (!sample.f_r.isFinite().all()) csv_.FailAt(reading_, "is too large");
    sample.sigma = Rgb::Constant((kDefaultRelativeSigma * std::abs(reading) + kRt300sFloor) /
                                 std::cos(receive));
    return sample;
  }

  CsvReader csv_;
  const CsvColumn clock_ = csv_.Require("clock");
  const CsvColumn azimuth_ = csv_.Require("azimuth_deg");
  const CsvColumn incidence_ = csv_.Require("incidence_deg");
  const CsvColumn receive_ = csv_.Require("receive_deg");
  const CsvColumn reading_ = csv_.Require("RT");
};

}  // namespace

Rt300sSession ParseRt300s(const std::string& text, const std::string& name) {
  return Reader(text, name).Read();
}

bool LooksLikeRt300s(const std::string& text) {
  try {
    const CsvReader csv(text, "");
    return csv.Find("incidence_deg") && csv.Find("receive_deg") && csv.Find("RT");
  } catch (const ConfigError&) {
    return false;
  }
}

}  // namespace gonio
