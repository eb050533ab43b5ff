// SPDX-License-Identifier: Apache-2.0
// Readings in the plane of incidence as they came, those below zero included.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "apps/gonio/report_figures.h"

namespace gonio {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr double kInPlane = RadFromDeg(1);  // an azimuth this near counts as in the plane
constexpr int kGreen = 1;                   // of one channel all three are alike
// From steep to grazing incidence, light enough for none to be lost on white.
constexpr const char* kColours[] = {"#440154", "#414487", "#2a788e",
                                    "#22a884", "#7ad151", "#e0a800"};

// One reading in the plane of incidence.
struct InPlane {
  double theta_o_deg = 0;  // positive on the mirror's side
  double f_r = 0;
  bool usable = true;
};
// By theta_i, to a tenth of a degree.
using Scans = std::map<int, std::vector<InPlane>>;

double Polar(const Eigen::Vector3d& w) { return AngleBetween(w, Eigen::Vector3d::UnitZ()); }

Scans ScansOf(const ReportFacts& facts) {
  Scans scans;
  for (const BrdfSample& sample : facts.session.Samples()) {
    const Eigen::Vector3d& wi = sample.directions.wi;
    const Eigen::Vector3d& wo = sample.directions.wo;
    const double out_of_plane = std::abs(wi.x() * wo.y() - wi.y() * wo.x());
    const double horizontal = std::hypot(wi.x(), wi.y()) * std::hypot(wo.x(), wo.y());
    if (out_of_plane > std::sin(kInPlane) * horizontal) continue;
    const double side = wi.x() * wo.x() + wi.y() * wo.y() <= 0 ? 1 : -1;
    scans[static_cast<int>(std::lround(10 * DegFromRad(Polar(wi))))].push_back(
        {side * DegFromRad(Polar(wo)), sample.f_r[kGreen],
         bool(std::isfinite(sample.sigma[kGreen]))});
  }
  std::erase_if(scans, [](const auto& scan) { return scan.second.size() < 3; });
  for (auto& [theta_i, scan] : scans) {
    std::stable_sort(scan.begin(), scan.end(), [](const InPlane& a, const InPlane& b) {
      return a.theta_o_deg < b.theta_o_deg;
    });
  }
  return scans;
}

// As many as there are colours, from the first to the last.
Scans Thinned(const Scans& scans) {
  Scans kept;
  const std::size_t most = std::size(kColours);
  std::size_t index = 0;
  for (const auto& scan : scans) {
    const std::size_t last = scans.size() - 1;
    for (std::size_t i = 0; i < most; ++i) {
      if (scans.size() <= most || index == i * last / (most - 1)) kept.insert(scan);
    }
    ++index;
  }
  return kept;
}

// Linear around zero, logarithmic beyond: asinh(f_r / linear).
struct ReadingAxis {
  double linear = 1e-3;
  double low = 0;
  double high = 0;

  explicit ReadingAxis(const Scans& scans) {
    for (const auto& [theta_i, scan] : scans) {
      for (const InPlane& reading : scan) {
        low = std::min(low, reading.f_r);
        high = std::max(high, reading.f_r);
      }
    }
    // The darkest decade that is told apart: below the lowest reading, if that is negative; else
    // what black velvet reflects.
    linear = low < 0 ? std::pow(10, std::floor(std::log10(-low / 3))) : 1e-3;
  }
  double At(double f_r) const { return std::asinh(f_r / linear); }

  std::string Script() const {
    std::string tics = fmt::format("'0' 0");
    for (double tic = linear; tic <= 10 * std::max(high, -low); tic *= 10) {
      const int decade = static_cast<int>(std::lround(std::log10(tic)));
      tics += fmt::format(", '10^{{{}}}' {:.6g}", decade, At(tic));
      if (low < -tic / 2) tics += fmt::format(", '−10^{{{}}}' {:.6g}", decade, At(-tic));
    }
    return fmt::format("set yrange [{:.6g}:{:.6g}]\nset ytics ({})\n", At(1.2 * low) - 0.15,
                       At(1.2 * high), tics);
  }
};

constexpr const char* kScript = R"(
set xrange [-90:90]
set xtics 30
set xlabel 'angle of the detector {/:Italic θ}_o [deg]; positive: the side of the mirror'
set ylabel '{/:Italic f}_r [1/sr], linear around zero'
set key outside right top vertical samplen 1 title '{/:Italic θ}_i'
)";

}  // namespace

std::optional<Figure> ReadingsFigure(const ReportFacts& facts) {
  const Scans all = ScansOf(facts);
  if (all.empty()) return std::nullopt;
  const Scans scans = Thinned(all);
  const ReadingAxis axis(scans);
  Plot plot{.title = "Readings in the plane of incidence", .script = kScript + axis.Script()};
  plot.script += "plot 0 with lines linewidth 1 linecolor '#323f4b' notitle";
  int number = 0;
  for (const auto& [theta_i, scan] : scans) {
    PlotTable used{fmt::format("scan{}", number), {}};
    PlotTable unused{fmt::format("unused{}", number), {}};
    for (const InPlane& reading : scan) {
      const double y = axis.At(reading.f_r);
      used.rows.push_back({reading.theta_o_deg, reading.usable ? y : kMissing});
      if (!reading.usable) unused.rows.push_back({reading.theta_o_deg, y});
    }
    const char* colour =
        kColours[number * (std::size(kColours) - 1) / std::max<std::size_t>(1, scans.size() - 1)];
    plot.script += fmt::format(
        ", ${} using 1:2 with linespoints linewidth 1.2 pointtype 7 pointsize 0.35 linecolor '{}' "
        "title '{:.4g}°'",
        used.name, colour, theta_i / 10.0);
    if (!unused.rows.empty()) {
      plot.script += fmt::format(
          ", ${} using 1:2 with points pointtype 6 pointsize 0.6 linecolor '{}' notitle",
          unused.name, colour);
      plot.tables.push_back(std::move(unused));
    }
    plot.tables.push_back(std::move(used));
    ++number;
  }
  plot.script += "\n";
  return Figure{std::move(plot),
                fmt::format("Readings of f_r (green) in the plane of incidence, {} of {} angles of "
                            "incidence, as they came: below zero, too. Rings: readings that are "
                            "not fitted.",
                            scans.size(), all.size())};
}

}  // namespace gonio
