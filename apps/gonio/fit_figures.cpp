// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/fit_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/gonio/report_axes.h"
#include "apps/gonio/summary.h"
#include "brdf/merl_table.h"
#include "brdf/metrics.h"
#include "core/error.h"
#include "fitting/hemi_epd.h"
#include "fitting/slice_data.h"

namespace gonio {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr int kSteps = 240;
// 1/sr: the parts of lobes below a hundredth of the sum's darkest are nothing to draw.
constexpr double kDarkest = 1e-4;
// From broad to narrow: of ColorBrewer's "Dark2", which the colour-blind can tell apart.
constexpr const char* kLobeColours[] = {"#1b9e77", "#d95f02", "#7570b3", "#e7298a", "#66a61e"};

// sqrt(theta_h), the sum, each lobe.
PlotTable Curves(const std::vector<Lobe>& lobes, LogRange* range) {
  PlotTable table{"curves", {}};
  for (const Lobe& lobe : lobes) range->Include(std::max(0.7 * EvalLobe(lobe, 0), 1e-3));
  for (int i = 0; i < kSteps; ++i) {
    const double s = (i + 0.5) / kSteps;
    const double theta_h = s * s * kPi / 2;
    std::vector<double>& row = table.rows.emplace_back(1, SqrtDeg(theta_h));
    double sum = 0;
    for (const Lobe& lobe : lobes) sum += EvalLobe(lobe, LogCos(theta_h));
    row.push_back(std::max(sum, kDarkest / 10));
    // The model is zero at the horizon, which a logarithmic axis does not have.
    if (theta_h < RadFromDeg(80)) range->Include(std::max(sum, kDarkest));
    for (const Lobe& lobe : lobes) {
      const double f_r = EvalLobe(lobe, LogCos(theta_h));
      row.push_back(f_r > kDarkest / 100 ? f_r : kMissing);
    }
  }
  return table;
}

PlotTable Points(const Brdf& reference, const SliceFigureOptions& options, LogRange* range) {
  const int cell = std::clamp(static_cast<int>(options.theta_d / (kPi / 2) * MerlTable::kThetaD), 0,
                              MerlTable::kThetaD - 1);
  const SliceData slice = SliceAt(reference, cell, {.keep_every = options.keep_every});
  PlotTable table{"points", {}};
  for (const SlicePoint& point : slice.points[options.channel]) {
    const bool shown = point.cells > 0 && point.f_r > 0;
    table.rows.push_back({SqrtDeg(point.theta_h), shown ? point.f_r : kMissing});
    if (shown && point.theta_h < RadFromDeg(80)) range->Include(point.f_r);
  }
  return table;
}

}  // namespace

Plot LobesPlot(const LobeModel& model, const Brdf* reference, const SliceFigureOptions& options) {
  const std::vector<Lobe> lobes = model.LobesAt(options.theta_d, options.channel);
  if (lobes.empty()) {
    throw ConfigError(fmt::format("{}: knows no {}", model.name(), kChannelNames[options.channel]));
  }
  LogRange range;
  const std::string title =
      fmt::format("{}, {}, theta_d = {:.1f} deg", reference ? reference->name() : model.name(),
                  kChannelNames[options.channel], DegFromRad(options.theta_d));
  Plot plot{.title = "Data and lobes: " + title, .width = 620, .height = 430};
  plot.tables.push_back(Curves(lobes, &range));
  if (reference) plot.tables.push_back(Points(*reference, options, &range));
  plot.script = ThetaHAxis() + range.Axis('y', 1.6) +
                "set ylabel '{/:Italic f}_r [1/sr]'\nset key top right\nset title " +
                Quoted(title) + " noenhanced font ',14' textcolor '#1f2933'\nplot ";
  if (reference) {
    plot.script +=
        "$points using 1:2 with points pointtype 6 pointsize 0.7 linecolor '#52606d' title "
        "'data', ";
  }
  plot.script += "$curves using 1:2 with lines linewidth 2.2 linecolor '#1f2933' title 'sum'";
  for (std::size_t k = 0; k < lobes.size(); ++k) {
    plot.script += fmt::format(
        ", $curves using 1:{} with lines linewidth 1.6 dashtype (6,3) linecolor '{}' "
        "title 'κ = {:.3g}, γ = {:.3g}'",
        3 + k, kLobeColours[k % std::size(kLobeColours)], lobes[k].kappa, lobes[k].gamma);
  }
  plot.script += "\n";
  return plot;
}

Plot ErrorMapPlot(const Brdf& reference, const Brdf& other, int channel) {
  MetricOptions options = AllCores();
  options.phi_stride = 2;
  const std::vector<double> errors = ErrorMap(reference, other, channel, options);
  PlotTable table{"map", {}};
  double most = 0;
  // Corners instead of centres: gnuplot's pm3d paints between them. theta_h lies square-root
  // spaced.
  for (int h = 0; h < MerlTable::kThetaH; ++h) {
    for (int d = 0; d < MerlTable::kThetaD; ++d) {
      const double error = errors[static_cast<std::size_t>(h) * MerlTable::kThetaD + d];
      if (std::isfinite(error)) most = std::max(most, error);
      table.rows.push_back(
          {SqrtDeg(MerlTable::CellCentre(h, d, 0).theta_h), d + 0.5, std::max(error, 1e-5)});
    }
    table.rows.emplace_back();
  }
  const std::string title =
      fmt::format("{} against {}, {}", other.name(), reference.name(), kChannelNames[channel]);
  Plot plot{.title = "Map of the error: " + title, .width = 680, .height = 460};
  plot.tables.push_back(std::move(table));
  plot.script = ThetaHAxis() + fmt::format(R"(set yrange [0:90]
set ytics 15
set ylabel 'difference angle {{/:Italic θ}}_d [deg]'
set palette defined (0 '#440154', 0.25 '#3b528b', 0.5 '#21918c', 0.75 '#5ec962', 1 '#fde725')
set logscale cb
set cbrange [1e-4:{:.3g}]
set format cb '10^{{%T}}'
set cblabel 'mean |Δ ln(1 + {{/:Italic f}}_r cos {{/:Italic θ}}_i)|' textcolor '#1f2933'
set colorbox noborder
unset key
set title {} noenhanced font ',14' textcolor '#1f2933'
plot $map using 1:2:3 with image pixels
)",
                                           std::max(most, 2e-4), Quoted(title));
  return plot;
}

}  // namespace gonio
