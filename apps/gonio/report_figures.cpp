// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/report_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "acquisition/kinematics.h"
#include "apps/gonio/report_axes.h"
#include "apps/gonio/report_imported.h"

namespace gonio {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr double kScoredPolar = RadFromDeg(80);  // metrics stop there

// ---- the map of poses

// The candidates the rig can reach, each row's neighbours joined into rectangles.
PlotTable ReachableCells(const ReportFacts& facts) {
  const CandidateOptions& raster = facts.plan.candidates;
  const Kinematics kinematics(facts.rig);
  const std::vector<Candidate> candidates =
      MakeCandidates(raster, [&](const DirectionPair& pair) { return kinematics.Reachable(pair); });
  const auto edge = [&](int row) {
    const double share = static_cast<double>(row) / raster.theta_h_count;
    return raster.merl_spacing ? std::sqrt(90.0) * share : std::sqrt(90 * share);
  };
  const double height = 90.0 / raster.theta_d_count;
  PlotTable table{"reachable", {}};
  for (std::size_t i = 0; i < candidates.size();) {
    std::size_t last = i;
    while (last + 1 < candidates.size() && candidates[last + 1].row == candidates[i].row &&
           candidates[last + 1].column == candidates[last].column + 1) {
      ++last;
    }
    // A little wider than they are: no seams between rectangles.
    table.rows.push_back({edge(candidates[i].row), edge(candidates[i].row + 1) + 0.01,
                          candidates[i].column * height, (candidates[last].column + 1) * height});
    i = last + 1;
  }
  return table;
}

std::vector<double> MapPoint(const HalfDiff& angles, int order) {
  return {SqrtDeg(angles.theta_h), DegFromRad(angles.theta_d), static_cast<double>(order)};
}

constexpr const char* kPoseMapScript = R"(
set yrange [0:90]
set ytics 15
set ylabel 'difference angle {/:Italic θ}_d [deg]'
set palette defined (0 '#440154', 0.25 '#3b528b', 0.5 '#21918c', 0.75 '#5ec962', 1 '#fde725')
set cblabel 'order of measurement' textcolor '#1f2933'
set colorbox noborder
set cbtics out scale 0.6
set key above left horizontal
)";

constexpr const char* kReachableLayer =
    "$reachable using (($1+$2)/2):(($3+$4)/2):1:2:3:4 with boxxyerror fillcolor '#eceff3' "
    "title 'within reach'";
// Twice: a dark rim keeps the light end of the palette visible.
constexpr const char* kChosenLayer =
    ", $chosen using 1:2 with points pointtype 7 pointsize {1:.3g} linecolor '#323f4b' notitle"
    ", $chosen using 1:2:3 with points pointtype 7 pointsize {2:.3g} linecolor palette notitle"
    ", NaN with points pointtype 7 pointsize 0.9 linecolor '#21918c' title {0}";
constexpr const char* kOpeningLayer =
    ", $opening using 1:2 with points pointtype 13 pointsize 1.3 linecolor '#323f4b' notitle"
    ", $opening using 1:2 with points pointtype 13 pointsize 1.0 linecolor '#e8590c' "
    "title 'opening'";
constexpr const char* kRefusedLayer =
    ", $refused using 1:2 with points pointtype 2 pointsize 0.9 linewidth 2 linecolor '#c92a2a' "
    "title 'refused'";

// Relative; smaller where a dense scan would hide its own points.
double PointSize(const ReportFacts& facts) {
  return std::clamp(std::sqrt(300.0 / static_cast<double>(facts.session.poses.size() + 1)), 0.25,
                    1.0);
}

int NumberOfLast(const ReportFacts& facts) {
  return facts.session.poses.empty() ? 0 : facts.session.poses.back().pose;
}

std::string PoseMapCaption(const ReportFacts& facts) {
  std::string caption =
      fmt::format("The {} measured poses, coloured by the order they were measured in.",
                  facts.session.poses.size());
  if (IsImported(facts)) return caption;
  caption += " Grey: poses of the plan's raster that this rig can reach.";
  if (facts.plan.kind == PlannerKind::kInformation) {
    caption +=
        " Diamonds: the fixed opening; every later pose was chosen from the uncertainty of the "
        "fit to those before it.";
  }
  if (!facts.refusals.empty()) caption += " Crosses: poses that were refused.";
  return caption;
}

// ---- slices

// 1/sr, black velvet: where no sample holds it, a fit may say 1e-18, which is nothing to draw.
constexpr double kDarkest = 1e-3;
constexpr int kSliceSteps = 180;
// Where a fit is compared with the truth: any phi_d will do for the fit, and here both directions
// are above the horizon for every theta_h and theta_d.
constexpr double kSlicePhi = kPi / 2;

// The largest theta_h [rad] at kSlicePhi with both directions on what errors are scored on.
double ScoredThetaH(double theta_d) {
  return std::acos(std::min(1.0, std::cos(kScoredPolar) / std::cos(theta_d)));
}

// sqrt(theta_h), then for each channel: fit, fit - 2 sigma, fit + 2 sigma, truth.
PlotTable SliceCurves(const ReportFacts& facts, double theta_d, LogRange* range) {
  PlotTable table{"curves", {}};
  // What is not scored may leave the picture.
  const double scored = kSliceSteps * std::sqrt(ScoredThetaH(theta_d) / (kPi / 2));
  for (int i = 0; i < kSliceSteps; ++i) {
    const double s = (i + 0.5) / kSliceSteps;
    const HalfDiff angles{s * s * kPi / 2, theta_d, kSlicePhi};
    const Prediction fit = facts.fit->Predict(angles);
    const std::optional<Rgb> truth = facts.truth ? facts.truth->Eval(angles) : std::optional<Rgb>();
    std::vector<double>& row = table.rows.emplace_back(1, SqrtDeg(angles.theta_h));
    for (int c = 0; c < kChannels; ++c) {
      const double t = truth ? (*truth)[c] : kMissing;
      // A logarithmic axis has no zero: a band that reaches it ends far below the picture.
      const double low = std::max(fit.f_r[c] - 2 * fit.sigma[c], 1e-9);
      row.insert(row.end(), {fit.f_r[c], low, fit.f_r[c] + 2 * fit.sigma[c], t});
      if (i >= scored) continue;
      range->Include(std::max(fit.f_r[c], kDarkest));
      range->Include(t);
    }
  }
  return table;
}

// sqrt(theta_h), then for each channel: f_r, f_r - 2 sigma, f_r + 2 sigma. A sample is carried
// along the fit to the slice, so that its distance from the curve is its residual: over 4 degrees
// f_r itself may change by more than all errors together.
PlotTable SliceSamples(const ReportFacts& facts, double theta_d, LogRange* range) {
  PlotTable table{"samples", {}};
  for (const BrdfSample& sample : facts.session.Samples()) {
    const HalfDiff angles = ToHalfDiff(sample.directions);
    if (std::abs(angles.theta_d - theta_d) > kSliceReach) continue;
    std::vector<double>& row = table.rows.emplace_back(1, SqrtDeg(angles.theta_h));
    const Rgb here = facts.fit->Predict({angles.theta_h, theta_d, kSlicePhi}).f_r;
    const Rgb carry = (here + kDarkest) / (facts.fit->Predict(angles).f_r + kDarkest);
    for (int c = 0; c < kChannels; ++c) {
      const double f = carry[c] * sample.f_r[c];
      const double spread = 2 * carry[c] * sample.sigma[c];
      const bool shown = f > 0 && std::isfinite(f + spread);
      if (shown) range->Include(std::max(f, kDarkest / 10));
      row.insert(row.end(), {shown ? f : kMissing, shown ? std::max(f - spread, 1e-9) : kMissing,
                             shown ? f + spread : kMissing});
    }
  }
  if (table.rows.empty()) table.rows.emplace_back(10, kMissing);
  return table;
}

// sqrt(theta_h) of samples in the slice with a usable reading that no logarithmic axis can show.
PlotTable SliceBelowZero(const ReportFacts& facts, double theta_d) {
  PlotTable table{"below", {}};
  for (const BrdfSample& sample : facts.session.Samples()) {
    const HalfDiff angles = ToHalfDiff(sample.directions);
    if (std::abs(angles.theta_d - theta_d) > kSliceReach) continue;
    if (!(sample.f_r <= 0 && sample.sigma.isFinite()).any()) continue;
    table.rows.push_back({SqrtDeg(angles.theta_h)});
  }
  return table;
}

std::string SlicePlotCommand(bool truth, double size) {
  std::string command = "plot ";
  for (int c = 0; c < kChannels; ++c) {
    command += fmt::format(
        "$curves using 1:{}:{} with filledcurves linecolor '{}' fillstyle transparent solid 0.18 "
        "noborder notitle, ",
        3 + 4 * c, 4 + 4 * c, kChannelColours[c]);
  }
  // Smaller and smaller, so that channels that agree show as rings.
  for (int c = 0; c < kChannels; ++c) {
    command += fmt::format(
        "$samples using 1:{1}:(0):(${2}-${1}) with vectors nohead linewidth 1 linecolor '{3}' "
        "notitle, $samples using 1:{0} with points pointtype 7 pointsize {4:.2f} linecolor '{3}' "
        "notitle, ",
        2 + 3 * c, 3 + 3 * c, 4 + 3 * c, kChannelColours[c], size * (0.8 - 0.18 * c));
  }
  for (int c = 0; c < kChannels; ++c) {
    command += fmt::format("$curves using 1:{} with lines linewidth 2 linecolor '{}' title '{}', ",
                           2 + 4 * c, kChannelColours[c], kChannelNames[c]);
  }
  for (int c = 0; c < kChannels && truth; ++c) {
    command += fmt::format(
        "$curves using 1:{} with lines linewidth 1.3 dashtype (4,4) linecolor '#1f2933' {}, ",
        5 + 4 * c, c == 0 ? "title 'truth'" : "notitle");
  }
  command += "NaN with points pointtype 7 pointsize 0.7 linecolor '#7b8794' title 'measured'";
  return command;
}

// Grey where one of the directions is beyond what errors are scored on.
std::string UnscoredShade(double theta_d) {
  return fmt::format(
      "set object 1 rectangle from first {:.5g}, graph 0 to graph 1, graph 1 behind "
      "fillcolor '#f0f2f5' fillstyle solid noborder\n",
      SqrtDeg(ScoredThetaH(theta_d)));
}

}  // namespace

Figure PoseMapFigure(const ReportFacts& facts) {
  Plot plot{.title = "Measured poses on the map of half and difference angles",
            .width = 760,
            .height = 470,
            .script = ThetaHAxis() + kPoseMapScript};
  const bool imported = IsImported(facts);
  if (!imported) plot.tables.push_back(ReachableCells(facts));
  PlotTable opening{"opening", {}};
  PlotTable chosen{"chosen", {}};
  PlotTable refused{"refused", {}};
  std::string reason = "measured";
  for (const MeasuredPose& pose : facts.session.poses) {
    const bool first = pose.reason == "opening";
    (first ? opening : chosen).rows.push_back(MapPoint(AnglesOf(pose), pose.pose));
    if (!first) reason = pose.reason;
  }
  for (const Refusal& refusal : facts.refusals) {
    refused.rows.push_back(MapPoint(refusal.angles, 0));
  }
  plot.script += fmt::format("set cbrange [1:{}]\nplot {}", std::max(2, NumberOfLast(facts)),
                             imported ? "NaN notitle" : kReachableLayer);
  if (!chosen.rows.empty()) {
    const double size = PointSize(facts);
    plot.script += fmt::format(kChosenLayer, Quoted(reason), 0.95 * size, 0.75 * size);
  }
  if (!opening.rows.empty()) plot.script += kOpeningLayer;
  if (!refused.rows.empty()) plot.script += kRefusedLayer;
  for (PlotTable* table : {&opening, &chosen, &refused}) {
    if (!table->rows.empty()) plot.tables.push_back(std::move(*table));
  }
  return {std::move(plot), PoseMapCaption(facts)};
}

Figure SliceFigure(const ReportFacts& facts, double theta_d) {
  LogRange range;
  Plot plot{.title = fmt::format("f_r over theta_h at theta_d = {:.0f} deg", DegFromRad(theta_d)),
            .width = 520,
            .height = 390,
            .tables = {SliceCurves(facts, theta_d, &range), SliceSamples(facts, theta_d, &range)}};
  plot.script = ThetaHAxis() + range.Axis('y', 1.5) + UnscoredShade(theta_d) +
                fmt::format(
                    "set ylabel '{{/:Italic f}}_r [1/sr]'\n"
                    "set title '{{/:Italic θ}}_d = {:.0f}°' font ',15' textcolor '#1f2933'\n"
                    "set y2range [0:1]\n"
                    "set key below center horizontal samplen 1 width -4\n",
                    DegFromRad(theta_d)) +
                SlicePlotCommand(facts.truth != nullptr, PointSize(facts));
  PlotTable below = SliceBelowZero(facts, theta_d);
  if (!below.rows.empty()) {
    plot.script +=
        ", $below using 1:(0.02) axes x1y2 with points pointtype 11 pointsize 0.7 linecolor "
        "'#323f4b' title 'zero or below'";
    plot.tables.push_back(std::move(below));
  }
  plot.script += "\n";
  return {std::move(plot), ""};
}

}  // namespace gonio
