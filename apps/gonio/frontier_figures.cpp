// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "apps/gonio/report_axes.h"
#include "apps/gonio/statistics.h"

namespace gonio {
namespace {

// ColorBrewer's "Dark2" and what is left of "Set1" beside it.
constexpr const char* kColours[] = {"#1b9e77", "#d95f02", "#7570b3", "#e7298a", "#66a61e",
                                    "#e6ab02", "#a6761d", "#666666", "#377eb8", "#e41a1c"};
constexpr int kPanelWidth = 430;
constexpr int kPanelHeight = 400;

struct Group {
  std::string noise;
  bool held_out = false;
  std::string Title() const {
    return fmt::format("{}, noise {}", held_out ? "held-out materials" : "cross-validated", noise);
  }
  bool operator==(const Group&) const = default;
};

template <typename Items>
std::vector<Group> GroupsOf(const Items& items) {
  std::vector<Group> groups;
  for (const auto& item : items) {
    const Group group{item.noise, item.held_out};
    if (std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
  }
  return groups;
}

std::vector<std::string> ContestantsOf(const FrontierResult& result) {
  std::vector<std::string> names;
  for (const FrontierCell& cell : result.cells) {
    if (std::find(names.begin(), names.end(), cell.contestant) == names.end()) {
      names.push_back(cell.contestant);
    }
  }
  return names;
}

std::string Layout(std::size_t panels) {
  return fmt::format(
      "set multiplot layout 1,{} margins {:.4f},0.985,0.13,0.93 spacing {:.4f},0.1\n", panels,
      0.16 / static_cast<double>(panels), panels == 1 ? 0.1 : 0.06);
}

double DenseMedian(const FrontierResult& result, bool held_out) {
  std::vector<double> errors;
  for (const DenseCell& cell : result.dense) {
    if (cell.held_out == held_out) errors.push_back(cell.male);
  }
  return Median(errors);
}

// Cost, median, quartiles of one contestant.
PlotTable CurveOf(const ContestantSummary& summary, Cost cost, const std::string& name, LogRange* x,
                  LogRange* y) {
  PlotTable table{name, {}};
  for (const BudgetSummary& at : summary.budgets) {
    const double spent = cost == Cost::kPoses ? at.budget : at.minutes;
    table.rows.push_back({spent, at.median, at.q25, at.q75});
    x->Include(spent);
    for (const double error : {at.median, at.q25, at.q75}) y->Include(error);
  }
  return table;
}

// The bands of a group's contestants, then their lines, each followed by a comma.
std::string Curves(const Group& group, const std::vector<ContestantSummary>& summaries,
                   const std::vector<std::string>& contestants, Cost cost, bool legend,
                   std::vector<PlotTable>* tables, LogRange* x, LogRange* y) {
  std::string bands, lines;
  for (const ContestantSummary& summary : summaries) {
    if (Group{summary.noise, summary.held_out} != group) continue;
    const auto at = std::find(contestants.begin(), contestants.end(), summary.contestant);
    const char* colour =
        kColours[static_cast<std::size_t>(at - contestants.begin()) % std::size(kColours)];
    tables->push_back(CurveOf(summary, cost, fmt::format("t{}", tables->size()), x, y));
    const std::string& name = tables->back().name;
    bands += fmt::format(
        "${} using 1:3:4 with filledcurves fillstyle transparent solid 0.1 noborder linecolor "
        "'{}' title '', ",
        name, colour);
    lines += fmt::format(
        "${} using 1:2 with linespoints linewidth 2 pointtype 7 pointsize 0.4 linecolor '{}' "
        "title {}, ",
        name, colour, legend ? Quoted(summary.contestant) : "''");
  }
  return bands + lines;
}

// A table of points (x, y) for each contestant, in their order.
class Scatter {
 public:
  explicit Scatter(const std::vector<std::string>& contestants) : contestants_(contestants) {}

  void Add(const std::string& contestant, double x, double y) {
    points_[contestant].push_back({x, y});
  }
  bool empty() const { return points_.empty(); }

  // The plot's elements, after appending the tables.
  std::string Elements(std::vector<PlotTable>* tables, bool legend) const {
    std::string elements;
    for (std::size_t i = 0; i < contestants_.size(); ++i) {
      const auto found = points_.find(contestants_[i]);
      if (found == points_.end()) continue;
      tables->push_back({fmt::format("t{}", tables->size()), found->second});
      elements += fmt::format(
          ", ${} using 1:2 with points pointtype 7 pointsize 0.45 linecolor '{}' title {}",
          tables->back().name, kColours[i % std::size(kColours)],
          legend ? Quoted(contestants_[i]) : "''");
    }
    return elements;
  }

 private:
  const std::vector<std::string>& contestants_;
  std::map<std::string, std::vector<std::vector<double>>> points_;
};

constexpr const char* kKey = "opaque noenhanced samplen 1.2 spacing 0.9 font ',10'\n";

}  // namespace

Plot FrontierPlot(const FrontierResult& result, const std::vector<ContestantSummary>& summaries,
                  Cost cost) {
  const std::vector<Group> groups = GroupsOf(summaries);
  Plot plot{.title = fmt::format("Error against {} of {}",
                                 cost == Cost::kPoses ? "poses" : "minutes", result.name),
            .width = static_cast<int>(groups.size()) * kPanelWidth,
            .height = kPanelHeight};
  LogRange x, y;
  std::string panels;
  for (const Group& group : groups) {
    const bool first = group == groups.front();
    const double dense = DenseMedian(result, group.held_out);
    y.Include(dense);
    panels += fmt::format("set title '{}' offset 0,-0.5\nset ylabel '{}' offset 1,0\nplot ",
                          group.Title(), first ? "MALE" : "") +
              Curves(group, summaries, ContestantsOf(result), cost, first, &plot.tables, &x, &y);
    // Without a dense fit the line is off the picture.
    panels += fmt::format(
        "{:.6g} with lines dashtype 2 linewidth 1.5 linecolor '#1f2933' title '{}'\n",
        std::isfinite(dense) ? dense : 1e-12, first && std::isfinite(dense) ? "dense fit" : "");
  }
  plot.script = Layout(groups.size()) + x.Axis('x', 1.1) + y.Axis('y', 1.2) +
                fmt::format("set xlabel '{}'\nset key bottom left ",
                            cost == Cost::kPoses ? "poses" : "minutes on the session clock") +
                kKey + panels + "unset multiplot\n";
  return plot;
}

std::optional<Plot> CoveragePlot(const FrontierResult& result) {
  const std::vector<std::string> contestants = ContestantsOf(result);
  std::vector<std::string> materials;
  for (const DenseCell& cell : result.dense) materials.push_back(cell.material);
  const std::vector<Group> groups = GroupsOf(result.cells);
  Plot plot{.title = "Coverage of 90 % intervals of " + result.name,
            .width = std::max(500, 130 + 22 * static_cast<int>(materials.size())),
            .height = 40 + 330 * static_cast<int>(groups.size())};
  std::string panels;
  for (const Group& group : groups) {
    std::map<std::pair<std::string, std::size_t>, std::vector<double>> shares;
    for (const FrontierCell& cell : result.cells) {
      if (Group{cell.noise, cell.held_out} != group || cell.rows.empty()) continue;
      const double share = cell.rows.back().coverage[kNinety];
      const auto at = std::find(materials.begin(), materials.end(), cell.material);
      if (!std::isfinite(share) || at == materials.end()) continue;
      shares[{cell.contestant, static_cast<std::size_t>(at - materials.begin())}].push_back(share);
    }
    Scatter scatter(contestants);
    for (const auto& [key, values] : shares) {
      scatter.Add(key.first, static_cast<double>(key.second), 100 * MeanOf(values));
    }
    if (scatter.empty()) continue;
    panels += fmt::format("set title '{}' offset 0,-0.5\n", group.Title()) +
              "plot 90 with lines linewidth 1.5 linecolor '#1f2933' title ''" +
              scatter.Elements(&plot.tables, true) + "\n";
  }
  if (panels.empty()) return std::nullopt;
  std::string tics;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    tics += fmt::format("{}{} {}", i > 0 ? ", " : "", Quoted(materials[i]), i);
  }
  plot.script = fmt::format(
      "set multiplot layout {},1\nset yrange [0:100]\nset xrange [-0.7:{}]\n"
      "set xtics rotate by 60 right noenhanced font ',9' ({})\n"
      "set ylabel 'directions inside [%]'\nset key bottom left {}"
      "set object 1 rectangle from graph 0, first {} to graph 1, first {} behind fillcolor "
      "'#e8edf2' fillstyle solid noborder\n",
      groups.size(), static_cast<double>(materials.size()) - 0.3, tics, kKey, 100 * kCalibratedFrom,
      100 * kCalibratedTo);
  plot.script += panels + "unset multiplot\n";
  return plot;
}

std::optional<Plot> PredictedErrorPlot(const FrontierResult& result) {
  const std::vector<std::string> contestants = ContestantsOf(result);
  const std::vector<Group> groups = GroupsOf(result.cells);
  Plot plot{.title = "True against predicted error of " + result.name,
            .width = static_cast<int>(groups.size()) * kPanelWidth,
            .height = kPanelHeight};
  LogRange range;
  std::string panels;
  for (const Group& group : groups) {
    Scatter scatter(contestants);
    for (const FrontierCell& cell : result.cells) {
      if (Group{cell.noise, cell.held_out} != group) continue;
      for (const FrontierRow& row : cell.rows) {
        if (!(row.predicted_error > 0 && row.male > 0)) continue;
        scatter.Add(cell.contestant, row.predicted_error, row.male);
        range.Include(row.predicted_error);
        range.Include(row.male);
      }
    }
    if (scatter.empty()) continue;
    panels += fmt::format("set title '{}' offset 0,-0.5\nset ylabel '{}' offset 1,0\n",
                          group.Title(), panels.empty() ? "true MALE" : "") +
              "plot x with lines linewidth 1 linecolor '#1f2933' title ''" +
              scatter.Elements(&plot.tables, panels.empty()) + "\n";
  }
  if (panels.empty()) return std::nullopt;
  plot.script = Layout(groups.size()) + range.Axis('x', 1.2) + range.Axis('y', 1.2) +
                "set xlabel 'predicted error'\nset key top left " + kKey + panels +
                "unset multiplot\n";
  return plot;
}

void WriteFrontierFigures(const std::filesystem::path& dir, const FrontierResult& result,
                          const std::vector<ContestantSummary>& summaries) {
  if (summaries.empty()) return;
  std::filesystem::create_directories(dir);
  const auto write = [&](const char* name, const Plot& plot) {
    for (const char* extension : {".svg", ".png"}) {
      WritePlot(dir / (std::string(name) + extension), plot);
    }
  };
  write("error-poses", FrontierPlot(result, summaries, Cost::kPoses));
  write("error-minutes", FrontierPlot(result, summaries, Cost::kMinutes));
  if (const auto plot = CoveragePlot(result)) write("coverage", *plot);
  if (const auto plot = PredictedErrorPlot(result)) write("predicted-error", *plot);
}

}  // namespace gonio
