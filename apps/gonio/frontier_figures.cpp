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

// A contestant in all the pictures. Its symbol and colour belong to it alone among some sixty.
struct Style {
  std::string contestant;
  bool process = false;  // its reconstruction gives intervals, as only a process does
  const char* colour = nullptr;
  int symbol = 0;  // gnuplot's pointtype
};
// Okabe and Ito's strong colours for processes, duller ones for what they compete with.
constexpr const char* kProcessColours[] = {"#d55e00", "#0072b2", "#009e73", "#cc79a7"};
constexpr const char* kRivalColours[] = {"#7570b3", "#b8860b", "#5f6b76", "#d0609a", "#6b9e2e",
                                         "#8c564b", "#2aa5b5", "#9aa5b1", "#b04a4a"};
constexpr int kSymbols[] = {7, 5, 9, 11, 13, 6, 4};  // discs, squares, triangles, diamonds

// Sizes in px of a panel's axes and of what is around them.
constexpr int kPanelWidth = 370;
constexpr int kPanelHeight = 350;
constexpr int kLeft = 78;
constexpr int kGap = 66;
constexpr int kTop = 30;
constexpr int kBottom = 62;
constexpr int kLegendWidth = 200;

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

// In the study's order.
std::vector<Style> StylesOf(const FrontierResult& result) {
  std::vector<Style> styles;
  for (const FrontierCell& cell : result.cells) {
    auto at = std::find_if(styles.begin(), styles.end(),
                           [&](const Style& style) { return style.contestant == cell.contestant; });
    if (at == styles.end()) at = styles.insert(at, {cell.contestant, false, nullptr, 0});
    for (const FrontierRow& row : cell.rows) at->process |= std::isfinite(row.coverage[kNinety]);
  }
  std::size_t processes = 0, rivals = 0;
  for (Style& style : styles) {
    std::size_t& count = style.process ? processes : rivals;
    style.colour = style.process ? kProcessColours[count % std::size(kProcessColours)]
                                 : kRivalColours[count % std::size(kRivalColours)];
    style.symbol = kSymbols[count++ % std::size(kSymbols)];
  }
  return styles;
}

// As drawn: the first on top, and processes on top of what they compete with.
std::vector<Style> InDrawingOrder(std::vector<Style> styles) {
  std::reverse(styles.begin(), styles.end());
  std::stable_partition(styles.begin(), styles.end(),
                        [](const Style& style) { return !style.process; });
  return styles;
}

std::string LineOf(const Style& style) {
  return fmt::format("with linespoints linewidth {} pointtype {} pointsize {} linecolor '{}'",
                     style.process ? 3 : 1.4, style.symbol, style.process ? 0.7 : 0.55,
                     style.colour);
}

std::string PointsOf(const Style& style, double size) {
  return fmt::format("with points pointtype {} pointsize {} linecolor '{}'", style.symbol, size,
                     style.colour);
}

// An entry of the legend, which has an order of its own: nothing is drawn with it.
std::string Entry(const std::string& look, const std::string& name) {
  return fmt::format(", NaN {} title {}", look, Quoted(name));
}

// Panels side by side, the legend at the right of them all.
struct Row {
  explicit Row(std::size_t panels) : count(static_cast<int>(panels)) {}
  int AxesEnd() const { return kLeft + count * kPanelWidth + (count - 1) * kGap; }
  int Width() const { return AxesEnd() + kLegendWidth; }
  int Height() const { return kTop + kPanelHeight + kBottom; }
  std::string Layout() const {
    const double width = Width(), height = Height();
    return fmt::format(
        "set multiplot layout 1,{} margins {:.4f},{:.4f},{:.4f},{:.4f} spacing {:.4f},0\n", count,
        kLeft / width, AxesEnd() / width, kBottom / height, 1 - kTop / height, kGap / width);
  }
  int count;
};

std::string LegendAt(int x_px, int width_px, int top_px, int height_px) {
  return fmt::format(
      "set key at screen {:.4f},{:.4f} left top vertical maxrows 40 noenhanced samplen 2 "
      "spacing 1.1 font ',11'\n",
      static_cast<double>(x_px) / width_px, 1 - static_cast<double>(top_px) / height_px);
}

double DenseMedian(const FrontierResult& result, bool held_out) {
  std::vector<double> errors;
  for (const DenseCell& cell : result.dense) {
    if (cell.held_out == held_out) errors.push_back(cell.male);
  }
  return Median(errors);
}

// Cost, median, quartiles of one contestant.
PlotTable CurveOf(const ContestantSummary& summary, Cost cost, bool band, const std::string& name,
                  LogRange* x, LogRange* y) {
  PlotTable table{name, {}};
  for (const BudgetSummary& at : summary.budgets) {
    const double spent = cost == Cost::kPoses ? at.budget : at.minutes;
    table.rows.push_back({spent, at.median, at.q25, at.q75});
    x->Include(spent);
    y->Include(at.median);
    if (!band) continue;
    y->Include(at.q25);
    y->Include(at.q75);
  }
  return table;
}

// The bands of a group's processes (of all contestants they would hide each other), then all
// lines, each followed by a comma.
std::string Curves(const Group& group, const std::vector<ContestantSummary>& summaries,
                   const std::vector<Style>& styles, Cost cost, std::vector<PlotTable>* tables,
                   LogRange* x, LogRange* y) {
  std::string bands, lines;
  for (const Style& style : InDrawingOrder(styles)) {
    for (const ContestantSummary& summary : summaries) {
      if (Group{summary.noise, summary.held_out} != group) continue;
      if (summary.contestant != style.contestant) continue;
      tables->push_back(
          CurveOf(summary, cost, style.process, fmt::format("t{}", tables->size()), x, y));
      const std::string& name = tables->back().name;
      if (style.process) {
        bands += fmt::format(
            "${} using 1:3:4 with filledcurves fillstyle transparent solid 0.12 noborder "
            "linecolor '{}' title '', ",
            name, style.colour);
      }
      lines += fmt::format("${} using 1:2 {} title '', ", name, LineOf(style));
    }
  }
  return bands + lines;
}

// A table of points (x, y) for each contestant.
class Scatter {
 public:
  void Add(const std::string& contestant, double x, double y) {
    points_[contestant].push_back({x, y});
  }
  bool empty() const { return points_.empty(); }

  // The plot's elements, after appending the tables.
  std::string Elements(const std::vector<Style>& styles, double size,
                       std::vector<PlotTable>* tables) const {
    std::string elements;
    for (const Style& style : InDrawingOrder(styles)) {
      const auto found = points_.find(style.contestant);
      if (found == points_.end()) continue;
      tables->push_back({fmt::format("t{}", tables->size()), found->second});
      elements +=
          fmt::format(", ${} using 1:2 {} title ''", tables->back().name, PointsOf(style, size));
    }
    return elements;
  }

 private:
  std::map<std::string, std::vector<std::vector<double>>> points_;
};

// 90 % intervals at the largest budget, materials along the axis.
struct CoveragePanel {
  Group group;
  std::vector<std::string> materials;
  // By contestant, then index of the material: a share for each seed.
  std::map<std::string, std::map<std::size_t, std::vector<double>>> shares;

  CoveragePanel(const FrontierResult& result, const Group& of) : group(of) {
    for (const FrontierCell& cell : result.cells) {
      if (Group{cell.noise, cell.held_out} != group || cell.rows.empty()) continue;
      const double share = cell.rows.back().coverage[kNinety];
      if (!std::isfinite(share)) continue;
      auto at = std::find(materials.begin(), materials.end(), cell.material);
      if (at == materials.end()) at = materials.insert(at, cell.material);
      shares[cell.contestant][static_cast<std::size_t>(at - materials.begin())].push_back(share);
    }
  }
  int Count() const { return static_cast<int>(materials.size()); }
  // Of the axes; wide enough for the title, and for names side by side.
  int Width() const { return Count() * std::clamp(960 / std::max(1, Count()), 24, 60) + 100; }
  // Of the names, which lean.
  int Bottom() const {
    std::size_t longest = 0;
    for (const std::string& name : materials) longest = std::max(longest, name.size());
    return 24 + static_cast<int>(5.6 * static_cast<double>(longest));
  }
  int Height() const { return kTop + kAxesHeight + Bottom(); }
  // Contestants stand side by side in a material's column.
  std::string Elements(const std::vector<Style>& processes, std::vector<PlotTable>* tables) const {
    Scatter scatter;
    const double apart = std::min(0.6 / static_cast<double>(processes.size()),
                                  10.0 * static_cast<double>(Count()) / Width());
    const double middle = 0.5 * static_cast<double>(processes.size() - 1);
    for (std::size_t i = 0; i < processes.size(); ++i) {
      const auto found = shares.find(processes[i].contestant);
      if (found == shares.end()) continue;
      const double shift = (static_cast<double>(i) - middle) * apart;
      for (const auto& [material, values] : found->second) {
        scatter.Add(found->first, static_cast<double>(material) + shift, MeanOf(values));
      }
    }
    return scatter.Elements(processes, kMarkSize, tables);
  }
  // Axes from `top_px` of a picture downwards.
  std::string Axes(int top_px, int width_px, int height_px) const {
    const double width = width_px, height = height_px;
    std::string tics;
    for (std::size_t i = 0; i < materials.size(); ++i) {
      tics += fmt::format("{}{} {}", i > 0 ? ", " : "", Quoted(materials[i]), i);
    }
    return fmt::format(
        "set lmargin at screen {:.4f}\nset rmargin at screen {:.4f}\nset tmargin at screen {:.4f}\n"
        "set bmargin at screen {:.4f}\nset xrange [-0.5:{}]\n"
        "set xtics rotate by 60 right noenhanced font ',10' ({})\n"
        "set title '{}' offset 0,-0.5\n",
        kLeft / width, (kLeft + Width()) / width, 1 - (top_px + kTop) / height,
        1 - (top_px + kTop + kAxesHeight) / height, static_cast<double>(Count()) - 0.5, tics,
        group.Title());
  }

  static constexpr int kAxesHeight = 260;  // px
  static constexpr double kMarkSize = 0.75;
};

}  // namespace

Plot FrontierPlot(const FrontierResult& result, const std::vector<ContestantSummary>& summaries,
                  Cost cost) {
  const std::vector<Group> groups = GroupsOf(summaries);
  const std::vector<Style> styles = StylesOf(result);
  const Row row(groups.size());
  Plot plot{.title = fmt::format("Error against {} of {}",
                                 cost == Cost::kPoses ? "poses" : "minutes", result.name),
            .width = row.Width(),
            .height = row.Height()};
  constexpr const char* kDense = "with lines dashtype 2 linewidth 2 linecolor '#1f2933'";
  LogRange x, y;
  std::string panels;
  for (const Group& group : groups) {
    const double dense = DenseMedian(result, group.held_out);
    y.Include(dense);
    panels += fmt::format("set title '{}' offset 0,-0.5\nset ylabel '{}' offset 1,0\nplot ",
                          group.Title(), panels.empty() ? "median MALE" : "") +
              Curves(group, summaries, styles, cost, &plot.tables, &x, &y);
    // Without a dense fit the line is off the picture.
    panels += fmt::format("{:.6g} {} title ''", std::isfinite(dense) ? dense : 1e-12, kDense);
    if (group == groups.front()) {
      for (const Style& style : styles) panels += Entry(LineOf(style), style.contestant);
      if (std::isfinite(dense)) panels += Entry(kDense, "dense fit");
    }
    panels += "\n";
  }
  plot.script = row.Layout() + x.Axis('x', 1.1) + y.Axis('y', 1.2) +
                fmt::format("set xlabel '{}'\n",
                            cost == Cost::kPoses ? "poses" : "minutes on the session clock") +
                LegendAt(row.AxesEnd() + 14, row.Width(), kTop, row.Height()) + panels +
                "unset multiplot\n";
  return plot;
}

std::optional<Plot> CoveragePlot(const FrontierResult& result) {
  std::vector<Style> processes = StylesOf(result);
  std::erase_if(processes, [](const Style& style) { return !style.process; });
  std::vector<CoveragePanel> panels;
  int width = 0, height = 0;
  for (const Group& group : GroupsOf(result.cells)) {
    CoveragePanel panel(result, group);
    if (panel.materials.empty()) continue;
    width = std::max(width, kLeft + panel.Width() + kLegendWidth);
    height += panel.Height();
    panels.push_back(std::move(panel));
  }
  if (panels.empty()) return std::nullopt;
  Plot plot{
      .title = "Coverage of 90 % intervals of " + result.name, .width = width, .height = height};
  plot.script = fmt::format(
      "set multiplot\nset yrange [0:1]\nset ytics 0.2\nset ylabel 'share of directions inside'\n"
      "set object 1 rectangle from graph 0, first {} to graph 1, first {} behind fillcolor "
      "'#dfe6ed' fillstyle solid noborder\n",
      kCalibratedFrom, kCalibratedTo);
  plot.script += LegendAt(kLeft + panels.front().Width() + 14, width, kTop, height);
  int top = 0;
  for (const CoveragePanel& panel : panels) {
    plot.script += panel.Axes(top, width, height) +
                   "plot 0.9 with lines linewidth 1.5 linecolor '#1f2933' title ''" +
                   panel.Elements(processes, &plot.tables);
    for (const Style& style : processes) {
      if (top == 0) plot.script += Entry(PointsOf(style, panel.kMarkSize), style.contestant);
    }
    plot.script += "\n";
    top += panel.Height();
  }
  plot.script += "unset multiplot\n";
  return plot;
}

std::optional<Plot> PredictedErrorPlot(const FrontierResult& result) {
  const std::vector<Style> styles = StylesOf(result);
  const std::vector<Group> groups = GroupsOf(result.cells);
  LogRange range;
  std::map<std::string, bool> drawn;  // contestants that predict
  std::vector<std::pair<Group, Scatter>> scatters;
  for (const Group& group : groups) {
    Scatter scatter;
    for (const FrontierCell& cell : result.cells) {
      if (Group{cell.noise, cell.held_out} != group) continue;
      for (const FrontierRow& row : cell.rows) {
        if (!(row.predicted_error > 0 && row.male > 0)) continue;
        scatter.Add(cell.contestant, row.predicted_error, row.male);
        drawn[cell.contestant] = true;
        range.Include(row.predicted_error);
        range.Include(row.male);
      }
    }
    if (!scatter.empty()) scatters.emplace_back(group, std::move(scatter));
  }
  if (scatters.empty()) return std::nullopt;
  const Row row(scatters.size());
  Plot plot{.title = "True against predicted error of " + result.name,
            .width = row.Width(),
            .height = row.Height()};
  std::string panels;
  for (const auto& [group, scatter] : scatters) {
    const bool first = panels.empty();
    panels += fmt::format("set title '{}' offset 0,-0.5\nset ylabel '{}' offset 1,0\n",
                          group.Title(), first ? "true MALE" : "") +
              "plot x with lines linewidth 1 linecolor '#1f2933' title ''" +
              scatter.Elements(styles, 0.4, &plot.tables);
    for (const Style& style : styles) {
      if (first && drawn[style.contestant]) panels += Entry(PointsOf(style, 0.7), style.contestant);
    }
    panels += "\n";
  }
  plot.script = row.Layout() + range.Axis('x', 1.2) + range.Axis('y', 1.2) +
                "set xtics rotate by 40 right\nset xlabel 'predicted error'\n" +
                LegendAt(row.AxesEnd() + 14, row.Width(), kTop, row.Height()) + panels +
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
