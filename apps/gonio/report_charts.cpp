// SPDX-License-Identifier: Apache-2.0
// Error, durations and lobes: the pictures with few numbers.

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <limits>

#include "apps/gonio/progress.h"
#include "apps/gonio/report_axes.h"
#include "apps/gonio/report_figures.h"
#include "fitting/slice.h"

namespace gonio {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

double Hours(Seconds duration) { return duration.count() / 3600; }

// ---- error over poses

PlotTable ErrorTable(const std::string& name, const std::vector<ErrorPoint>& points,
                     LogRange* poses, LogRange* errors) {
  PlotTable table{name, {}};
  for (const ErrorPoint& point : points) {
    table.rows.push_back({static_cast<double>(point.poses), point.error});
    poses->Include(point.poses);
    errors->Include(point.error);
  }
  if (points.empty()) table.rows.push_back({kMissing, kMissing});
  return table;
}

// ---- durations

struct Part {
  const char* name;
  const char* colour;
};
constexpr Part kParts[] = {{"travel", "#33658a"},
                           {"settling", "#86bbd8"},
                           {"exposure and read-out", "#f6ae2d"},
                           {"homing, refused poses", "#b0bac5"}};

struct Bar {
  std::string name;
  int poses;
  double parts[std::size(kParts)];  // hours
  double Total() const { return parts[0] + parts[1] + parts[2] + parts[3]; }
};

Bar BarOf(const std::string& name, const TimeEstimate& e) {
  return {name, e.poses, {Hours(e.travel), Hours(e.settling), Hours(e.exposing), 0}};
}

// For each part a table of its rectangles, stacked: left, right, bottom, top.
std::vector<PlotTable> StackedBars(const std::vector<Bar>& bars) {
  std::vector<PlotTable> tables;
  std::vector<double> begin(bars.size(), 0);
  for (std::size_t part = 0; part < std::size(kParts); ++part) {
    PlotTable& table = tables.emplace_back(PlotTable{fmt::format("part{}", part), {}});
    for (std::size_t i = 0; i < bars.size(); ++i) {
      const double y = -static_cast<double>(i);
      const double end = begin[i] + bars[i].parts[part];
      table.rows.push_back({begin[i], end, y - 0.3, y + 0.3});
      begin[i] = end;
    }
  }
  return tables;
}

// Two panels side by side, kappa and gamma, each: theta_d, then channel by channel all lobes.
PlotTable LobeTable(const DsbrdfFit& fit, bool gamma, LogRange* range) {
  const DsbrdfShape& shape = fit.model().shape();
  PlotTable table{gamma ? "gamma" : "kappa", {}};
  constexpr int kSteps = 90;
  for (int i = 0; i <= kSteps; ++i) {
    const double theta_d = kPi / 2 * i / kSteps;
    const Slice slice(shape, fit.model().parameters(), theta_d);
    std::vector<double>& row = table.rows.emplace_back(1, DegFromRad(theta_d));
    for (int c = 0; c < kChannels; ++c) {
      for (int lobe = 0; lobe < shape.lobes; ++lobe) {
        row.push_back(gamma ? slice.gamma(c, lobe) : slice.kappa(c, lobe));
        range->Include(row.back());
      }
    }
  }
  return table;
}

std::string LobePanel(const PlotTable& table, const LogRange& range, const std::string& label,
                      int lobes) {
  std::string script = range.Axis('y', 1.5) + "set ylabel '" + label + "'\nplot ";
  for (int c = 0; c < kChannels; ++c) {
    for (int lobe = 0; lobe < lobes; ++lobe) {
      script += fmt::format(
          "${} using 1:{} with lines linewidth 1.8 dashtype {} linecolor '{}' notitle, ",
          table.name, 2 + c * lobes + lobe, lobe + 1, kChannelColours[c]);
    }
  }
  for (int lobe = 1; lobe <= lobes; ++lobe) {
    script += fmt::format(
        "{}NaN with lines linewidth 1.8 dashtype {} linecolor '#3e4c59' title 'lobe {}'",
        lobe > 1 ? ", " : "", lobe, lobe);
  }
  return script + "\n";
}

constexpr const char* kErrorScript = R"(
set xlabel 'number of poses'
set ylabel 'mean absolute error of ln(1 + {/:Italic f}_r cos {/:Italic θ}_i)'
set key top right
)";

constexpr const char* kDurationScript = R"(
set border 1
set xlabel 'hours on the rig'
set grid noytics xtics
unset ytics
set key at graph 0.98, graph 0.02 right bottom vertical samplen 1.2
)";

}  // namespace

bool HasErrorFigure(const ReportFacts& facts) {
  return facts.true_error.size() + facts.planner_error.size() > 1;
}

Figure ErrorFigure(const ReportFacts& facts) {
  LogRange errors;
  LogRange poses;
  Plot plot{.title = "Error over the number of poses",
            .tables = {ErrorTable("planner", facts.planner_error, &poses, &errors),
                       ErrorTable("truth", facts.true_error, &poses, &errors)}};
  plot.script = poses.Axis('x', 1.08) + errors.Axis('y', 1.25) + kErrorScript + "plot ";
  std::string caption = "Both axes logarithmic; the error is dimensionless.";
  if (facts.male) {
    plot.script += fmt::format(
        "{:.6g} with lines linewidth 1 dashtype (6,5) linecolor '#7b8794' title 'final error "
        "{:.4f}', $truth using 1:2 with linespoints linewidth 2 pointtype 7 pointsize 0.7 "
        "linecolor '#1f2933' title 'true error (MALE)', ",
        *facts.male, *facts.male);
    caption +=
        " True error: the session's fit made again from its first poses only, against the known "
        "material.";
  }
  if (!facts.planner_error.empty()) {
    caption += " Expected error: what the planner believed at the time, without knowing the truth.";
  }
  plot.script += "$planner using 1:2 with lines linewidth 2 linecolor '#e8590c' ";
  plot.script += facts.planner_error.empty() ? "notitle\n"
                 : facts.plan.information.gain.objective == Objective::kMale
                     ? "title 'expected by the planner'\n"
                     : "title 'expected by the planner, of ln {/:Italic f}_r'\n";
  return {std::move(plot), caption};
}

Figure DurationFigure(const ReportFacts& facts) {
  const SessionTimes& t = facts.times;
  const std::vector<Bar> bars = {
      BarOf("dense scan", facts.dense), BarOf("30 %% of its rows", facts.thinned),
      Bar{"this session",
          static_cast<int>(facts.session.poses.size()),
          {Hours(t.travel), Hours(t.settling), Hours(t.exposing), Hours(t.homing + t.other)}}};
  Plot plot{.title = "Hours of a dense scan, a thinned scan and this session",
            .height = 250,
            .script = kDurationScript,
            .tables = StackedBars(bars)};
  plot.script +=
      fmt::format("set xrange [0:{:.6g}]\nset yrange [-2.6:0.6]\n", 1.5 * bars[0].Total());
  plot.script += "set ytics scale 0 (";
  for (std::size_t i = 0; i < bars.size(); ++i) {
    plot.script +=
        fmt::format("{}{} {}", i > 0 ? ", " : "", Quoted(bars[i].name), -static_cast<int>(i));
  }
  plot.script += ")\n";
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const Seconds total(3600 * bars[i].Total());
    plot.script += fmt::format("set label '{}, {} poses' at {:.6g}, -{} left offset 0.8, 0\n",
                               ForPeople(total), bars[i].poses, bars[i].Total(), i);
  }
  plot.script += "plot ";
  for (std::size_t i = 0; i < std::size(kParts); ++i) {
    plot.script += fmt::format(
        "{}$part{} using (($1+$2)/2):(($3+$4)/2):1:2:3:4 with boxxyerror fillcolor '{}' title '{}'",
        i > 0 ? ", " : "", i, kParts[i].colour, kParts[i].name);
  }
  return {std::move(plot), ""};
}

Figure LobeFigure(const ReportFacts& facts) {
  const int lobes = facts.fit->model().shape().lobes;
  LogRange kappa_range;
  LogRange gamma_range;
  const PlotTable kappa = LobeTable(*facts.fit, false, &kappa_range);
  const PlotTable gamma = LobeTable(*facts.fit, true, &gamma_range);
  Plot plot{.title = "The fit's lobes over theta_d", .width = 1000, .height = 360};
  plot.script =
      "set multiplot layout 1, 2\nset xrange [0:90]\nset xtics 15\n"
      "set xlabel 'difference angle {/:Italic θ}_d [deg]'\nset key above left horizontal\n" +
      LobePanel(kappa, kappa_range, "{/:Italic κ}, height", lobes) +
      LobePanel(gamma, gamma_range, "{/:Italic γ}, sharpness", lobes) + "unset multiplot\n";
  plot.tables = {kappa, gamma};
  return {std::move(plot),
          "Parameters of the fitted lobes exp(κ cos^γ θ_h) − 1 over θ_d, in the colours of their "
          "channels. Both axes are logarithmic; κ and γ are dimensionless."};
}

}  // namespace gonio
