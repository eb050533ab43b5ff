// SPDX-License-Identifier: Apache-2.0
// gonio check: which poses a rig can measure, and what keeps it from the others.

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "acquisition/reach.h"
#include "apps/gonio/build_rig.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/json_file.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/plot.h"

namespace gonio {
namespace {

using nlohmann::json;

constexpr int kStepDeg = 2;
constexpr int kCells = 90 / kStepDeg;

// Of an in-plane rig: with the light farther from the normal, and with the camera.
std::vector<int> PhisDeg(RigKind kind) {
  return IsInPlane(kind) ? std::vector{0, 180} : std::vector{0, 45, 90};
}

struct Kind {
  Reach reach;
  const char* text;
  const char* key;  // in JSON
  const char* colour;
};
constexpr std::array kKinds = {
    Kind{Reach::kMeasurable, "measurable", "measurable", "#1b9e77"},
    Kind{Reach::kLimits, "beyond an axis, max_polar_deg or min_separation_deg", "limits",
         "#c9d1d9"},
    Kind{Reach::kKeepOut, "arms would touch", "keep_out", "#d95f02"},
    Kind{Reach::kCutOff, "no way to it", "cut_off", "#7570b3"},
};

// One phi_d: the physical poses of a raster and where they are in it.
struct Panel {
  int phi_d_deg = 0;
  std::vector<DirectionPair> poses;
  std::vector<std::array<double, 2>> at_deg;  // theta_h, theta_d
  ReachMap map;
};

Panel MakePanel(const RigConfig& rig, int phi_d_deg) {
  Panel panel;
  panel.phi_d_deg = phi_d_deg;
  for (int h = 0; h < kCells; ++h) {
    for (int d = 0; d < kCells; ++d) {
      const std::array at = {(h + 0.5) * kStepDeg, (d + 0.5) * kStepDeg};
      const DirectionPair pair = ToDirections({.theta_h = RadFromDeg(at[0]),
                                               .theta_d = RadFromDeg(at[1]),
                                               .phi_d = RadFromDeg(phi_d_deg)});
      if (!pair.above_horizon()) continue;
      panel.poses.push_back(pair);
      panel.at_deg.push_back(at);
    }
  }
  panel.map = MapReach(rig, panel.poses);
  return panel;
}

void Print(const Panel& panel) {
  fmt::print("phi_d {:>3} deg      {} poses, {} deg apart\n", panel.phi_d_deg, panel.poses.size(),
             kStepDeg);
  for (const Kind& kind : kKinds) {
    const int count = panel.map.Count(kind.reach);
    if (count > 0) {
      fmt::print("  {:>5.1f} %  {}\n", 100.0 * count / static_cast<double>(panel.poses.size()),
                 kind.text);
    }
  }
  for (const auto& [who, count] : panel.map.blame)
    fmt::print("           {}: {} poses\n", who, count);
}

json ToJson(const std::vector<Panel>& panels) {
  json list = json::array();
  for (const Panel& panel : panels) {
    json entry = {{"phi_d_deg", panel.phi_d_deg},
                  {"poses", panel.poses.size()},
                  {"keep_out_by", panel.map.blame}};
    for (const Kind& kind : kKinds) entry[kind.key] = panel.map.Count(kind.reach);
    list.push_back(entry);
  }
  return list;
}

// Of the kinds that there are, each once.
std::string Key(const std::vector<Panel>& panels) {
  std::string key;
  for (const Kind& kind : kKinds) {
    int count = 0;
    for (const Panel& panel : panels) count += panel.map.Count(kind.reach);
    if (count == 0) continue;
    key += fmt::format(", NaN with points pointtype 5 linecolor '{}' title {}", kind.colour,
                       Quoted(kind.text));
  }
  return key;
}

std::string DrawPanel(const Panel& panel, bool first, const std::string& key, Plot* plot) {
  std::string points;
  for (const Kind& kind : kKinds) {
    PlotTable table{fmt::format("p{}_{}", panel.phi_d_deg, kind.key), {}};
    for (std::size_t i = 0; i < panel.poses.size(); ++i) {
      if (panel.map.poses[i] != kind.reach) continue;
      table.rows.push_back({panel.at_deg[i][0], panel.at_deg[i][1]});
    }
    if (table.rows.empty()) continue;
    points += fmt::format(
        "{}${} using 1:2 with points pointtype 5 pointsize 0.42 linecolor '{}' title ''",
        points.empty() ? "" : ", ", table.name, kind.colour);
    plot->tables.push_back(std::move(table));
  }
  return fmt::format(
      "set title 'phi_d = {} deg' noenhanced\nset ylabel '{}' noenhanced\n{}\nplot {}{}\n",
      panel.phi_d_deg, first ? "theta_d [deg]" : "",
      first ? "set key at screen 0.05,0.02 left bottom vertical noenhanced" : "unset key", points,
      first ? key : "");
}

Plot Draw(const std::string& rig_name, const std::vector<Panel>& panels) {
  Plot plot;
  plot.title = "Poses that " + rig_name + " can measure";
  plot.width = 360 * static_cast<int>(panels.size());
  plot.height = 460;
  plot.script = fmt::format("set multiplot layout 1,{} margins {:.2f},0.99,0.3,0.92 spacing 0.05\n",
                            panels.size(), 0.18 / static_cast<double>(panels.size()));
  plot.script +=
      "set xrange [0:90]\nset yrange [0:90]\nset xtics 30\nset ytics 30\n"
      "set xlabel 'theta_h [deg]' noenhanced\nset size ratio 1\n";
  const std::string key = Key(panels);
  for (const Panel& panel : panels) {
    plot.script += DrawPanel(panel, &panel == panels.data(), key, &plot);
  }
  plot.script += "unset multiplot\n";
  return plot;
}

}  // namespace

int CheckCommand(const CheckOptions& options) {
  if (!options.out.empty()) CheckPlotPath(options.out);
  const RigFile rig = LoadRig(LocateConfig(options.rig));
  std::vector<Panel> panels;
  for (const int phi : PhisDeg(rig.config.geometry.kind))
    panels.push_back(MakePanel(rig.config, phi));
  if (options.json != "-") {
    fmt::print("rig              {}\n", rig.config.name);
    for (const Panel& panel : panels) Print(panel);
  }
  if (!options.json.empty()) WriteJson(options.json, ToJson(panels));
  if (!options.out.empty()) {
    WritePlot(options.out, Draw(rig.config.name, panels));
    if (options.json != "-") fmt::print("wrote            {}\n", options.out.string());
  }
  for (const Panel& panel : panels) {
    if (panel.map.Count(Reach::kMeasurable) > 0) return kDone;
  }
  fmt::print(stderr, "gonio: {}: no pose can be measured\n", options.rig);
  return kFailed;
}

}  // namespace gonio
