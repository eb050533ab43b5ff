// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/study_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/gonio/report_axes.h"
#include "apps/gonio/study_summary.h"
#include "core/error.h"

namespace gonio {
namespace {

// The paper's materials stand out; of ColorBrewer's "Dark2".
struct Highlight {
  const char* material;
  const char* colour;
};
constexpr Highlight kHighlights[] = {{"white-acrylic", "#1b9e77"},
                                     {"light-brown-fabric", "#d95f02"},
                                     {"pink-fabric", "#e7298a"},
                                     {"alum-bronze", "#7570b3"},
                                     {"delrin", "#66a61e"}};

constexpr int kPanelWidth = 330;
constexpr int kPanelHeight = 330;

const Highlight* FindHighlight(const std::string& material) {
  const auto* found = std::find_if(std::begin(kHighlights), std::end(kHighlights),
                                   [&](const Highlight& h) { return material == h.material; });
  return found == std::end(kHighlights) ? nullptr : found;
}

PlotTable CurveTable(const std::string& name, const std::vector<int>& keep_every,
                     const std::vector<double>& error, LogRange* range) {
  PlotTable table{name, {}};
  for (std::size_t i = 0; i < error.size(); ++i) {
    const double shown = error[i] > 0 ? error[i] : std::numeric_limits<double>::quiet_NaN();
    table.rows.push_back({100.0 / keep_every[i], shown});
    range->Include(shown);
  }
  return table;
}

// One panel: a metric of a method. Appends its tables.
std::string Panel(const MethodSummary& method, const MetricSummary& metric, const LogRange& range,
                  bool legend, bool first, std::vector<PlotTable>* tables) {
  std::string behind;
  std::string front;
  LogRange ignored;
  const auto name = [&] { return fmt::format("t{}", tables->size()); };
  for (const ThinningCurve& curve : metric.curves) {
    tables->push_back(CurveTable(name(), method.keep_every, curve.error, &ignored));
    const Highlight* highlight = FindHighlight(curve.material);
    (highlight ? front : behind) += fmt::format(
        "${} using 1:2 with lines linewidth {} linecolor '{}' title {}, ", tables->back().name,
        highlight ? 1.8 : 0.6, highlight ? highlight->colour : "#b8c2cc",
        highlight && legend ? Quoted(curve.material) : "''");
  }
  tables->push_back(CurveTable(name(), method.keep_every, metric.median, &ignored));
  const char* label = metric.metric == "MALE" ? "MALE" : "MSE of the table [1/sr^2]";
  return fmt::format("set title '{}' offset 0,-0.5\nset ylabel '{}' offset 1,0\n", method.method,
                     first ? label : "") +
         range.Axis('y', 1.3) +
         (legend ? "set key bottom right opaque noenhanced samplen 1.2 spacing 0.9 font ',10'\n"
                 : "unset key\n") +
         "plot " + behind + front +
         fmt::format(
             "${} using 1:2 with linespoints linewidth 3 pointtype 7 pointsize 0.5 "
             "linecolor '#1f2933' title 'median of {}'\n",
             tables->back().name, metric.curves.size());
}

LogRange RangeOf(const std::vector<MethodSummary>& summaries,
                 MetricSummary MethodSummary::*metric) {
  LogRange range;
  for (const MethodSummary& summary : summaries) {
    for (const ThinningCurve& curve : (summary.*metric).curves) {
      for (const double error : curve.error) range.Include(error);
    }
  }
  return range;
}

// 100 % at the left, as the paper counts density down.
std::string DensityAxis(const std::vector<int>& keep_every) {
  std::string tics;
  for (const int every : keep_every) {
    tics += fmt::format("{}'{:.3g}' {:.6g}", tics.empty() ? "" : ", ",
                        every > 8 ? std::round(100.0 / every) : 100.0 / every, 100.0 / every);
  }
  return fmt::format(
      "set logscale x\nset xrange [{:.4g}:{:.4g}]\nset xtics ({}) font ',10'\n"
      "set xlabel 'density of {{/:Italic θ}}_h [%]'\n",
      110.0 / keep_every.front(), 90.0 / keep_every.back(), tics);
}

}  // namespace

Plot DensityPlot(const StudyResult& study, const std::string& method) {
  std::vector<MethodSummary> summaries = Summarise(study);
  if (!method.empty()) {
    std::erase_if(summaries, [&](const MethodSummary& s) { return s.method != method; });
    if (summaries.empty()) {
      throw ConfigError(fmt::format("{}: has no method {}", study.name, method));
    }
  }
  if (summaries.empty()) throw ConfigError(study.name + ": nothing was fitted");
  const int panels = static_cast<int>(summaries.size());
  Plot plot{.title = "Error against density of " + study.name,
            .width = std::max(panels * kPanelWidth, 420),
            .height = 2 * kPanelHeight};
  plot.script = fmt::format(
      "set multiplot layout 2,{} margins {:.4f},0.985,0.085,0.955 "
      "spacing {:.4f},0.13\n",
      panels, panels == 1 ? 0.17 : 0.23 / panels, panels == 1 ? 0.1 : 0.07);
  plot.script += DensityAxis(summaries[0].keep_every);
  // The legend stands where curves leave room: below the last MALE panel's.
  for (const auto metric : {&MethodSummary::male, &MethodSummary::mse}) {
    const LogRange range = RangeOf(summaries, metric);
    for (const MethodSummary& summary : summaries) {
      const bool legend = metric == &MethodSummary::mse && &summary == &summaries.back();
      plot.script += Panel(summary, summary.*metric, range, legend, &summary == &summaries.front(),
                           &plot.tables);
    }
  }
  plot.script += "unset multiplot\n";
  return plot;
}

}  // namespace gonio
